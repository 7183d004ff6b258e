// Extrema of a quadratic on the unit sphere: the trust-region subproblem on its boundary.
//
// For the maximum of n' A n + b . n over |n| = 1, with A = V diag(e) V' and beta = V' b / 2, stationary points are y = beta / (mu + gap),
// where gap_i = e_max - e_i and mu >= 0 is the root of the secular equation |y(mu)| = 1. In the hard case beta has no part along the top
// eigenvector and |y(0)| < 1: the rest of the unit length goes along that eigenvector. The minimum is the maximum of the negated quadratic.
// Source: More and Sorensen 1983, Computing a Trust Region Step.
#include "lighting/quadratic.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

namespace lightcook::lighting {

namespace {

struct Eigen {
    glm::dvec3 values;   ///< ascending
    glm::dmat3 vectors;  ///< columns, orthonormal
};

/// Off-diagonal entries below this change no eigenvalue of a matrix of size 1.
constexpr double kNegligible = 1e-18;
/// A smaller linear part of a problem of size 1 counts as 0: its square would underflow, and the extremum does not depend on it.
constexpr double kNegligibleLinear = 1e-100;

/// Applies a Jacobi rotation in the plane of axes p and q that zeroes matrix[p][q].
template <int p, int q>
void rotateAway(glm::dmat3& matrix, glm::dmat3& vectors) {
    const double offDiagonal = matrix[p][q];
    if (std::abs(offDiagonal) < kNegligible) return;
    const double halfDifference = 0.5 * (matrix[q][q] - matrix[p][p]);
    const double hypotenuse = std::sqrt(halfDifference * halfDifference + offDiagonal * offDiagonal);
    const double t = std::copysign(1.0, halfDifference) * offDiagonal / (std::abs(halfDifference) + hypotenuse);
    const double c = 1 / std::sqrt(t * t + 1), s = t * c;
    constexpr int r = 3 - p - q;
    matrix[p][p] -= t * offDiagonal;
    matrix[q][q] += t * offDiagonal;
    matrix[p][q] = matrix[q][p] = 0;
    const double rp = matrix[r][p], rq = matrix[r][q];
    matrix[r][p] = matrix[p][r] = c * rp - s * rq;
    matrix[r][q] = matrix[q][r] = s * rp + c * rq;
    const glm::dvec3 vp = vectors[p], vq = vectors[q];
    vectors[p] = c * vp - s * vq;
    vectors[q] = s * vp + c * vq;
}

/// Computes eigenvalues and eigenvectors by cyclic Jacobi: slower than the trigonometric closed form, but its vectors stay orthonormal for
/// multiple eigenvalues. The matrix is scaled to about 1 by the caller. Of three million matrices none took more than four sweeps; the
/// limit stops a NaN.
Eigen eigenSymmetric(glm::dmat3 matrix) {
    glm::dmat3 vectors(1);
    for (int sweep = 0; sweep < 16; ++sweep) {
        if (std::max({std::abs(matrix[0][1]), std::abs(matrix[0][2]), std::abs(matrix[1][2])}) < kNegligible) break;
        rotateAway<0, 1>(matrix, vectors);
        rotateAway<0, 2>(matrix, vectors);
        rotateAway<1, 2>(matrix, vectors);
    }
    std::array<int, 3> order = {0, 1, 2};
    const auto swapIfDescending = [&](std::size_t a, std::size_t b) {
        if (matrix[order[b]][order[b]] < matrix[order[a]][order[a]]) std::swap(order[a], order[b]);
    };
    swapIfDescending(0, 1);
    swapIfDescending(1, 2);
    swapIfDescending(0, 1);
    Eigen result{};
    for (int i = 0; i < 3; ++i) {
        const int from = order[static_cast<std::size_t>(i)];
        result.values[i] = matrix[from][from];
        result.vectors[i] = vectors[from];
    }
    return result;
}

/// Returns the root mu >= 0 of sum_i (beta_i / (mu + gap_i))^2 = 1. Requires a root, and lower > 0 or gap_i > 0 wherever beta_i != 0.
/// Newton on 1 / |y(mu)| - 1, which is concave and rises: from the left it climbs to the root without overshooting.
double solveSecular(const glm::dvec3& beta, const glm::dvec3& gap, double lower, double upper) {
    double mu = lower;
    for (int iteration = 0; iteration < 128; ++iteration) {
        double squared = 0, slope = 0;
        for (int i = 0; i < 3; ++i) {
            if (beta[i] == 0) continue;
            const double reciprocal = 1 / (mu + gap[i]), y = beta[i] * reciprocal;
            squared += y * y;
            slope += y * y * reciprocal;
        }
        if (!(squared > 1)) break;  // at the root, or beyond it by rounding
        const double step = (std::sqrt(squared) - 1) * squared / slope;
        mu = std::min(upper, mu + step);
        // Newton converges quadratically: after a step of 1e-8 of mu only rounding is left.
        if (!(step > 1e-8 * mu)) break;
    }
    return mu;
}

/// Maximises 2 beta . y - sum_i gap_i y_i^2 over |y| = 1. gap: zero at `top`, which is 0 or 2, and rising from there.
glm::dvec3 maximize(const glm::dvec3& beta, const glm::dvec3& gap, int top) {
    const double upper = glm::length(beta);
    double lower = 0;
    for (int i = 0; i < 3; ++i) lower = std::max(lower, std::abs(beta[i]) - gap[i]);
    glm::dvec3 y(0);
    if (lower == 0) {
        // beta has no part along the top eigenvector. If |y(0)| < 1, the rest of the length goes along it, with either sign: the hard case.
        double squared = 0;
        for (int i = 0; i < 3; ++i) {
            y[i] = beta[i] == 0 ? 0 : beta[i] / gap[i];
            squared += y[i] * y[i];
        }
        if (squared <= 1) {
            y[top] = std::sqrt(1 - squared);
            return glm::normalize(y);
        }
    }
    // Two more lower bounds of the root start Newton closer: |beta| of the two nearest eigenvalues minus the larger gap, and of all three.
    constexpr int near = 1;
    const int far = 2 - top;
    lower = std::max({lower, std::sqrt(beta[top] * beta[top] + beta[near] * beta[near]) - gap[near], upper - gap[far]});
    const double mu = solveSecular(beta, gap, lower, upper);
    for (int i = 0; i < 3; ++i) y[i] = beta[i] == 0 ? 0 : beta[i] / (mu + gap[i]);
    return glm::normalize(y);
}

/// Returns the maximum minus the top eigenvalue, from differences to it, so that linear and isotropic quadratics stay exact.
double rise(const glm::dvec3& y, const glm::dvec3& beta, const glm::dvec3& gap) {
    return 2 * glm::dot(beta, y) - (gap.x * y.x * y.x + gap.y * y.y * y.y + gap.z * y.z * y.z);
}

double largest(const SphereQuadratic& quadratic) {
    double size = 0;
    for (int i = 0; i < 3; ++i) {
        size = std::max(size, std::abs(quadratic.linear[i]));
        for (int j = 0; j < 3; ++j) size = std::max(size, std::abs(quadratic.symmetric[i][j]));
    }
    return size;
}

}  // namespace

double SphereQuadratic::operator()(const glm::dvec3& n) const {
    return constant + glm::dot(linear, n) + glm::dot(n, symmetric * n);
}

SphereQuadratic sphereQuadratic(const ShDouble& coefficients, const ShBands& bands) {
    const ShDouble& k = coefficients;
    const double a = bands[2] * kShDifference;
    const double zonal = k[6] / std::numbers::sqrt3;
    SphereQuadratic result;
    result.constant = bands[0] * kShConstant * k[0];
    result.linear = bands[1] * kShLinear * glm::dvec3(k[3], k[1], k[2]);
    // 3 z^2 - 1 = 2 z^2 - x^2 - y^2 on the sphere.
    result.symmetric = a * glm::dmat3(k[8] - zonal, k[4], k[7],   //
                                      k[4], -k[8] - zonal, k[5],  //
                                      k[7], k[5], 2 * zonal);
    return result;
}

Extrema extremaOnSphere(const SphereQuadratic& quadratic) {
    const double size = largest(quadratic);
    Extrema result;
    if (size == 0) {
        result.minimum = result.maximum = quadratic.constant;
        return result;
    }
    // A power of two loses no bit, and keeps squares away from overflow and underflow.
    int exponent = 0;
    std::frexp(size, &exponent);
    const double up = std::ldexp(1.0, std::clamp(-exponent, -1020, 1020));
    const Eigen eigen = eigenSymmetric(quadratic.symmetric * up);
    glm::dvec3 beta = (quadratic.linear * up * 0.5) * eigen.vectors;  // row vector times matrix: dot products with the columns
    for (int i = 0; i < 3; ++i)
        if (std::abs(beta[i]) < kNegligibleLinear) beta[i] = 0;

    const glm::dvec3 gapAbove = glm::dvec3(eigen.values.z) - eigen.values;
    const glm::dvec3 atMaximum = maximize(beta, gapAbove, 2);
    result.maximum = quadratic.constant + (eigen.values.z + rise(atMaximum, beta, gapAbove)) / up;
    result.maximumAt = glm::normalize(eigen.vectors * atMaximum);

    const glm::dvec3 gapBelow = eigen.values - glm::dvec3(eigen.values.x);
    const glm::dvec3 atMinimum = maximize(-beta, gapBelow, 0);
    result.minimum = quadratic.constant + (eigen.values.x - rise(atMinimum, -beta, gapBelow)) / up;
    result.minimumAt = glm::normalize(eigen.vectors * atMinimum);
    return result;
}

}  // namespace lightcook::lighting
