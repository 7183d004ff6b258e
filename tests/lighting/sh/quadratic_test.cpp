#include "lighting/quadratic.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "lighting/radiometry.h"
#include "lighting/sphere.h"
#include "tests/lighting/quadrature.h"

namespace lightcook::lighting {
namespace {

using test::randomDirection;
using test::randomRotation;

double size(const SphereQuadratic& q) {
    double squared = 0;
    for (int i = 0; i < 3; ++i) squared += glm::dot(q.symmetric[i], q.symmetric[i]);
    return std::abs(q.constant) + glm::length(q.linear) + std::sqrt(squared);
}

SphereQuadratic negated(const SphereQuadratic& q) {
    return {-q.constant, -q.linear, -1.0 * q.symmetric};
}

ShDouble randomCoefficients(std::mt19937_64& random) {
    std::normal_distribution<double> normal;
    ShDouble coefficients{};
    for (double& value : coefficients) value = normal(random);
    return coefficients;
}

/// Climbs from n to a local maximum: Newton steps in the tangent plane, or gradient steps, halved until the value increases.
double climb(const SphereQuadratic& q, glm::dvec3 n) {
    double value = q(n);
    for (int step = 0; step < 60; ++step) {
        const glm::dmat3 frame = worldFromTangentFrame(n);
        const glm::dvec3 gradient = 2.0 * (q.symmetric * n) + q.linear;
        const double gx = glm::dot(frame[0], gradient), gy = glm::dot(frame[1], gradient), radial = glm::dot(n, gradient);
        const glm::dvec3 ax = q.symmetric * frame[0], ay = q.symmetric * frame[1];
        const double hxx = 2 * glm::dot(frame[0], ax) - radial, hyy = 2 * glm::dot(frame[1], ay) - radial, hxy = 2 * glm::dot(frame[0], ay);
        const double determinant = hxx * hyy - hxy * hxy;
        double dx = gx, dy = gy;
        if (determinant > 0 && hxx < 0) {
            dx = (hxy * gy - hyy * gx) / determinant;
            dy = (hxy * gx - hxx * gy) / determinant;
        }
        bool gained = false;
        for (double scale = 1; scale > 1e-6 && !gained; scale /= 2) {
            const glm::dvec3 next = glm::normalize(n + scale * (dx * frame[0] + dy * frame[1]));
            const double nextValue = q(next);
            if (nextValue > value) {
                n = next;
                value = nextValue;
                gained = true;
            }
        }
        if (!gained) break;
    }
    return value;
}

/// Searches the maximum: climbs from the best point of each octant. Two maxima can lie in one hemisphere, so the best point alone could
/// lead to the wrong one.
double searchedMaximum(const SphereQuadratic& q, const std::vector<glm::dvec3>& points) {
    std::array<glm::dvec3, 8> best{};
    std::array<double, 8> bestValue{};
    bestValue.fill(-std::numeric_limits<double>::infinity());
    for (const glm::dvec3& point : points) {
        const std::size_t octant = (point.x > 0 ? 1u : 0u) + (point.y > 0 ? 2u : 0u) + (point.z > 0 ? 4u : 0u);
        const double value = q(point);
        if (value > bestValue[octant]) {
            best[octant] = point;
            bestValue[octant] = value;
        }
    }
    double highest = bestValue[0];
    for (const glm::dvec3& start : best) highest = std::max(highest, climb(q, start));
    return highest;
}

/// Returns the maximum over |n| = 1 of sum a_i n_i^2 + b_i n_i by duality: min over mu >= 0 of top + mu + sum (b_i / 2)^2 / (mu + top -
/// a_i), which is convex. Ternary search over log mu in long double: slow, but independent of Newton's method.
long double dualMaximum(const std::array<double, 3>& a, const std::array<double, 3>& b) {
    const long double top = std::max({a[0], a[1], a[2]});
    const auto dual = [&](long double mu) {
        long double value = top + mu;
        for (std::size_t i = 0; i < 3; ++i) {
            const long double half = b[i] / 2.0L, gap = top - a[i];
            if (half != 0) value += half * half / (mu + gap);
        }
        return value;
    };
    long double low = -700, high = 60;
    for (int step = 0; step < 400; ++step) {
        const long double left = low + (high - low) / 3, right = high - (high - low) / 3;
        (dual(std::exp(left)) < dual(std::exp(right)) ? high : low) = dual(std::exp(left)) < dual(std::exp(right)) ? right : left;
    }
    return std::min({dual(std::exp(low)), dual(std::exp(high)), dual(std::exp(-11000.0L))});
}

void expectAttained(const SphereQuadratic& q, const Extrema& extrema) {
    const double tolerance = 1e-13 * size(q);
    EXPECT_NEAR(glm::length(extrema.maximumAt), 1, 1e-14);
    EXPECT_NEAR(glm::length(extrema.minimumAt), 1, 1e-14);
    EXPECT_NEAR(q(extrema.maximumAt), extrema.maximum, tolerance);
    EXPECT_NEAR(q(extrema.minimumAt), extrema.minimum, tolerance);
}

TEST(SphereQuadratic, HasTheValuesOfTheHarmonics) {
    std::mt19937_64 random(61);
    for (int trial = 0; trial < 200; ++trial) {
        const ShDouble coefficients = randomCoefficients(random);
        const ShBands bands = {0.7, -1.3, 2.1};
        const SphereQuadratic q = sphereQuadratic(coefficients, bands);
        const glm::dvec3 n = randomDirection(random);
        const ShDouble basis = evaluateBasis(n);
        double expected = 0;
        for (std::size_t i = 0; i < kShCount; ++i) expected += bands[static_cast<std::size_t>(kShBand[i])] * coefficients[i] * basis[i];
        EXPECT_NEAR(q(n), expected, 1e-13);
        EXPECT_EQ(q.symmetric, glm::transpose(q.symmetric));
    }
}

TEST(Extrema, OfAHundredThousandQuadraticsEqualASearch) {
    std::vector<glm::dvec3> points;
    for (int i = 0; i < 400; ++i) points.push_back(fibonacciSphere(i, 400));
    std::mt19937_64 random(62);
    double worst = 0;
    for (int trial = 0; trial < 100000; ++trial) {
        const SphereQuadratic q = sphereQuadratic(randomCoefficients(random), trial % 2 == 0 ? kExitRadianceBands : ShBands{1, 1, 1});
        const Extrema extrema = extremaOnSphere(q);
        const double scale = size(q);
        const double above = (searchedMaximum(q, points) - extrema.maximum) / scale;
        const double below = (extrema.minimum + searchedMaximum(negated(q), points)) / scale;
        worst = std::max({worst, std::abs(above), std::abs(below)});
        ASSERT_LE(above, 1e-14) << trial;  // the search found more than the maximum
        ASSERT_LE(below, 1e-14) << trial;
        expectAttained(q, extrema);
    }
    EXPECT_LE(worst, 1e-12);
}

TEST(Extrema, BoundManySampledDirections) {
    std::mt19937_64 random(63);
    for (int trial = 0; trial < 5; ++trial) {
        const SphereQuadratic q = sphereQuadratic(randomCoefficients(random), kExitRadianceBands);
        const Extrema extrema = extremaOnSphere(q);
        double lowest = 1e300, highest = -1e300;
        for (int i = 0; i < 400000; ++i) {
            const double value = q(fibonacciSphere(i, 400000));
            lowest = std::min(lowest, value);
            highest = std::max(highest, value);
        }
        EXPECT_LE(highest, extrema.maximum + 1e-15 * size(q));
        EXPECT_GE(lowest, extrema.minimum - 1e-15 * size(q));
        EXPECT_NEAR(highest, extrema.maximum, 1e-4 * size(q));
        EXPECT_NEAR(lowest, extrema.minimum, 1e-4 * size(q));
    }
}

TEST(Extrema, OfAConstantAreTheConstant) {
    for (const double constant : {0.0, 3.5, -1e-300}) {
        const Extrema extrema = extremaOnSphere({constant, glm::dvec3(0), glm::dmat3(0)});
        EXPECT_EQ(extrema.minimum, constant);
        EXPECT_EQ(extrema.maximum, constant);
        EXPECT_EQ(glm::length(extrema.maximumAt), 1);
        EXPECT_EQ(glm::length(extrema.minimumAt), 1);
    }
}

TEST(Extrema, OfALinearFunctionLieAlongIt) {
    const SphereQuadratic q{1, {3, 0, -4}, glm::dmat3(0)};
    const Extrema extrema = extremaOnSphere(q);
    EXPECT_DOUBLE_EQ(extrema.maximum, 6);
    EXPECT_DOUBLE_EQ(extrema.minimum, -4);
    for (int i = 0; i < 3; ++i) {
        EXPECT_NEAR(extrema.maximumAt[i], q.linear[i] / 5, 1e-15);
        EXPECT_NEAR(extrema.minimumAt[i], -q.linear[i] / 5, 1e-15);
    }
}

TEST(Extrema, OfAnIsotropicQuadraticAreItsConstants) {
    const Extrema flat = extremaOnSphere({1, glm::dvec3(0), glm::dmat3(0.3)});
    EXPECT_EQ(flat.minimum, 1.3);
    EXPECT_EQ(flat.maximum, 1.3);
    const Extrema tilted = extremaOnSphere({1, {0, 2, 0}, glm::dmat3(0.3)});
    EXPECT_DOUBLE_EQ(tilted.maximum, 3.3);
    EXPECT_DOUBLE_EQ(tilted.minimum, -0.7);
    EXPECT_EQ(tilted.maximumAt, glm::dvec3(0, 1, 0));
}

TEST(Extrema, OfAPureQuadraticAreItsEigenvalues) {
    glm::dmat3 diagonal(0);
    diagonal[0][0] = -1;
    diagonal[1][1] = 2;
    diagonal[2][2] = 0.5;
    const Extrema extrema = extremaOnSphere({0.25, glm::dvec3(0), diagonal});
    EXPECT_EQ(extrema.maximum, 2.25);
    EXPECT_EQ(extrema.minimum, -0.75);
    EXPECT_EQ(std::abs(extrema.maximumAt.y), 1);
    EXPECT_EQ(std::abs(extrema.minimumAt.x), 1);
}

// max of z^2 - x^2 + b x: for b / 4 < 1 the rest of the length goes along the top eigenvector, 1 + b^2 / 8; otherwise x = 1 gives b - 1.
TEST(Extrema, HardCaseWithTheLinearPartOrthogonalToTheTopEigenvector) {
    glm::dmat3 diagonal(0);
    diagonal[0][0] = -1;
    diagonal[2][2] = 1;
    for (const double b : {1e-200, 1e-9, 0.5, 3.0, 3.999999, 4.0, 4.000001, 10.0}) {
        const SphereQuadratic q{0, {b, 0, 0}, diagonal};
        const Extrema extrema = extremaOnSphere(q);
        EXPECT_NEAR(extrema.maximum, b <= 4 ? 1 + b * b / 8 : b - 1, 4e-15 * size(q)) << b;
        EXPECT_NEAR(extrema.minimum, -1 - b, 4e-15 * size(q)) << b;
        expectAttained(q, extrema);
    }
}

TEST(Extrema, HardCaseWithATwofoldTopEigenvalue) {
    glm::dmat3 diagonal(1);
    diagonal[0][0] = -1;
    const Extrema orthogonal = extremaOnSphere({0, {1, 0, 0}, diagonal});
    EXPECT_NEAR(orthogonal.maximum, 1 + 1.0 / 8, 1e-15);
    const Extrema along = extremaOnSphere({0, {0, 0, 2}, diagonal});
    EXPECT_NEAR(along.maximum, 3, 1e-15);
    EXPECT_NEAR(along.maximumAt.z, 1, 1e-15);
}

TEST(Extrema, NearTheHardCaseAndNearEqualEigenvaluesMatchTheDual) {
    std::mt19937_64 random(64);
    const std::array<double, 9> tinies = {0, 1e-200, 1e-100, 1e-30, 1e-20, 1e-16, 1e-12, 1e-8, 1e-3};
    for (const double along : tinies)
        for (const double split : tinies)
            for (const double across : {0.0, 1e-10, 0.5, 2 - 1e-9, 2.0, 2 + 1e-9, 3.9999999, 4.0, 7.0})
                for (const double scale : {1.0, 1e-140, 1e140}) {
                    const std::array<double, 3> a = {-1, 1 - split, 1}, b = {across, along, along * 0.5};
                    glm::dmat3 diagonal(0);
                    for (int i = 0; i < 3; ++i) diagonal[i][i] = a[static_cast<std::size_t>(i)];
                    // Unrotated, so that the solver sees the tiny numbers, and rotated, so that it has to find the axes.
                    const glm::dmat3 rotation = randomRotation(random);
                    const double expected = static_cast<double>(dualMaximum(a, b));
                    for (const glm::dmat3& turn : {glm::dmat3(1), rotation}) {
                        glm::dmat3 matrix = turn * diagonal * glm::transpose(turn);
                        matrix = 0.5 * (matrix + glm::transpose(matrix));
                        const SphereQuadratic q{0, scale * (turn * glm::dvec3(b[0], b[1], b[2])), scale * matrix};
                        const Extrema extrema = extremaOnSphere(q);
                        EXPECT_NEAR(extrema.maximum / scale, expected, 1e-13 * size(q) / scale) << along << ' ' << split << ' ' << across;
                        const Extrema mirrored = extremaOnSphere(negated(q));
                        EXPECT_NEAR(mirrored.minimum / scale, -expected, 1e-13 * size(q) / scale) << along << ' ' << split << ' ' << across;
                    }
                }
}

TEST(Extrema, EndForInputsThatAreNotFinite) {
    const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
    for (const double bad : {nan, infinity}) {
        glm::dmat3 matrix(1);
        matrix[0][1] = matrix[1][0] = bad;
        const Extrema quadratic = extremaOnSphere({0, {1, 2, 3}, matrix});
        EXPECT_FALSE(std::isfinite(quadratic.maximum));
        const Extrema linear = extremaOnSphere({0, {1, bad, 3}, glm::dmat3(1)});
        EXPECT_FALSE(std::isfinite(linear.maximum));
        EXPECT_FALSE(std::isfinite(extremaOnSphere({bad, {1, 2, 3}, glm::dmat3(1)}).maximum));
    }
}

}  // namespace
}  // namespace lightcook::lighting
