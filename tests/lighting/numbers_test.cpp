// Stated errors of lighting over the whole range of doubles, searched against long double.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <vector>

#include "lighting/display.h"
#include "lighting/quadratic.h"
#include "tests/lighting/worst_search.h"

namespace lightcook::lighting {
namespace {

using Real = long double;
using test::SearchBudget;
using test::SearchRange;
using Kind = SearchRange::Kind;
using RealMatrix = std::array<std::array<Real, 3>, 3>;
using RealVector = std::array<Real, 3>;

/// Diagonalizes a symmetric matrix by Jacobi rotations; b becomes its components along the eigenvectors.
void diagonalize(RealMatrix& a, RealVector& b) {
    for (int sweep = 0; sweep < 60; ++sweep)
        for (const auto& [p, q] : {std::array<std::size_t, 2>{0, 1}, {0, 2}, {1, 2}}) {
            if (a[p][q] == 0) continue;
            const Real theta = (a[q][q] - a[p][p]) / (2 * a[p][q]);
            const Real t = std::copysign(Real(1), theta) / (std::abs(theta) + std::hypot(theta, Real(1)));
            const Real c = 1 / std::hypot(t, Real(1)), s = t * c;
            for (std::size_t k = 0; k < 3; ++k) {
                const Real kp = a[k][p], kq = a[k][q];
                a[k][p] = c * kp - s * kq;
                a[k][q] = s * kp + c * kq;
            }
            for (std::size_t k = 0; k < 3; ++k) {
                const Real pk = a[p][k], qk = a[q][k];
                a[p][k] = c * pk - s * qk;
                a[q][k] = s * pk + c * qk;
            }
            a[p][q] = a[q][p] = 0;
            const Real bp = b[p], bq = b[q];
            b[p] = c * bp - s * bq;
            b[q] = s * bp + c * bq;
        }
}
/// Returns the maximum on the sphere by duality, top + min over mu >= 0 of mu + sum (b_i / 2)^2 / (mu + gap_i), whose derivative is
/// bisected over the logarithm of mu.
Real maximumOf(const SphereQuadratic& q, Real sign) {
    Real size = 0;
    for (int i = 0; i < 3; ++i) {
        size = std::max(size, std::abs(static_cast<Real>(q.linear[i])));
        for (int j = 0; j < 3; ++j) size = std::max(size, std::abs(static_cast<Real>(q.symmetric[i][j])));
    }
    if (size == 0) return sign * static_cast<Real>(q.constant);
    RealMatrix a{};
    RealVector b{};
    for (int i = 0; i < 3; ++i) {
        b[static_cast<std::size_t>(i)] = sign * static_cast<Real>(q.linear[i]) / size;
        for (int j = 0; j < 3; ++j)
            a[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] = sign * static_cast<Real>(q.symmetric[i][j]) / size;
    }
    diagonalize(a, b);
    const Real top = std::max({a[0][0], a[1][1], a[2][2]});
    const auto sum = [&](Real mu, int power) {
        Real out = 0;
        for (std::size_t i = 0; i < 3; ++i) {
            const Real gap = top - a[i][i];
            if (b[i] != 0) out += b[i] * b[i] / 4 / std::pow(mu + gap, Real(power));
        }
        return out;
    };
    Real low = -4000, high = 4;
    for (int step = 0; step < 120; ++step) {
        const Real middle = (low + high) / 2;
        (sum(std::exp2(middle), 2) > 1 ? low : high) = middle;
    }
    const Real mu = std::exp2(high);
    return sign * static_cast<Real>(q.constant) + size * (top + mu + sum(mu, 1));
}
Real valueOf(const SphereQuadratic& q, const glm::dvec3& n) {
    Real sum = 0, squares = 0;
    for (int i = 0; i < 3; ++i) {
        sum += static_cast<Real>(q.linear[i]) * static_cast<Real>(n[i]);
        squares += static_cast<Real>(n[i]) * static_cast<Real>(n[i]);
        for (int j = 0; j < 3; ++j) sum += static_cast<Real>(q.symmetric[i][j]) * static_cast<Real>(n[i]) * static_cast<Real>(n[j]);
    }
    EXPECT_NEAR(static_cast<double>(squares), 1, 1e-14);
    return static_cast<Real>(q.constant) + sum;
}

/// A quadratic of three eigenvalues, a linear part along the eigenvectors, and a rotation: equal eigenvalues and the hard case are equal
/// or zero numbers, and without a rotation the solver sees them so. The factor is its largest number.
SphereQuadratic quadraticOf(const std::vector<double>& in) {
    // The columns of a unit quaternion's rotation.
    const double x = in[7], y = in[8], z = in[9], f = 2 / (1 + x * x + y * y + z * z);
    const glm::dmat3 turn(1 - f * (y * y + z * z), f * (x * y + z), f * (x * z - y),  //
                          f * (x * y - z), 1 - f * (x * x + z * z), f * (y * z + x),  //
                          f * (x * z + y), f * (y * z - x), 1 - f * (x * x + y * y));
    glm::dmat3 diagonal(0);
    for (int i = 0; i < 3; ++i) diagonal[i][i] = in[static_cast<std::size_t>(i)];
    const glm::dmat3 a = turn * diagonal * glm::transpose(turn);
    double largest = 1e-300;
    for (std::size_t i = 0; i < 7; ++i) largest = std::max(largest, std::abs(in[i]));
    return {in[10] * (in[6] / largest), in[10] * (turn * (glm::dvec3(in[3], in[4], in[5]) / largest)),
            in[10] * (0.5 * (a + glm::transpose(a)) / largest)};
}
Real sizeOf(const SphereQuadratic& q) {
    Real squares = 0, slopes = 0;
    for (int i = 0; i < 3; ++i) {
        slopes += static_cast<Real>(q.linear[i]) * static_cast<Real>(q.linear[i]);
        for (int j = 0; j < 3; ++j) squares += static_cast<Real>(q.symmetric[i][j]) * static_cast<Real>(q.symmetric[i][j]);
    }
    return std::abs(static_cast<Real>(q.constant)) + std::sqrt(slopes) + std::sqrt(squares);
}
void expectExtrema(const SearchBudget& budget) {
    std::vector<SearchRange> ranges(7, {1e-30, 1, Kind::Signed});
    ranges.insert(ranges.end(), 3, {1e-20, 1, Kind::Signed});
    ranges.push_back({1e-307, 1e307});
    test::expectHolds("extremaOnSphere, within 1e-12 of the size", ranges, budget, [](const std::vector<double>& in) {
        const SphereQuadratic q = quadraticOf(in);
        const Real size = sizeOf(q), maximum = maximumOf(q, 1), minimum = -maximumOf(q, -1);
        if (size == 0) return Real(0);
        const Extrema found = extremaOnSphere(q);
        return std::max({std::abs(static_cast<Real>(found.maximum) - maximum), std::abs(static_cast<Real>(found.minimum) - minimum),
                         std::abs(valueOf(q, found.maximumAt) - maximum), std::abs(valueOf(q, found.minimumAt) - minimum)}) /
               (1e-12L * size);
    });
}

Real pq(Real nits) {
    const Real y = std::pow(std::clamp(nits / 10000, Real(0), Real(1)), Real(2610) / 16384);
    return std::pow((Real(3424) / 4096 + Real(2413) / 128 * y) / (1 + Real(2392) / 128 * y), Real(2523) / 32);
}
void expectCurve(const SearchBudget& budget) {
    const std::array<SearchRange, 1> nits = {{{5e-324, 1.7e308, Kind::Signed}}};
    test::expectHolds("perceptualQuantizer, within 1e-13", nits, budget, [](const std::vector<double>& in) {
        return std::abs(static_cast<Real>(perceptualQuantizer(in[0])) - pq(static_cast<Real>(in[0]))) / 1e-13L;
    });
}
/// Delta E ITP with the matrices of the program.
Real visibleTruth(const glm::dvec3& a, const glm::dvec3& b, const Display& display) {
    const glm::dmat3 primaries = bt2020FromRec709();
    const std::array<std::array<Real, 3>, 3> lms = {{{1688, 2146, 262}, {683, 2951, 462}, {99, 309, 3688}}};
    RealVector difference{};
    for (const bool isFirst : {true, false}) {
        RealVector code{};
        for (std::size_t k = 0; k < 3; ++k) {
            Real nits = 0;
            for (int row = 0; row < 3; ++row) {
                Real light = 0;
                for (int c = 0; c < 3; ++c)
                    light += static_cast<Real>(primaries[c][row]) *
                             (std::max(static_cast<Real>(isFirst ? a[c] : b[c]), Real(0)) * static_cast<Real>(display.nitsPerUnit) +
                              static_cast<Real>(display.black));
                nits += lms[k][static_cast<std::size_t>(row)] / 4096 * light;
            }
            code[k] = pq(nits);
        }
        for (std::size_t k = 0; k < 3; ++k) difference[k] += (isFirst ? 1 : -1) * code[k];
    }
    const auto& [l, m, s] = difference;
    const Real i = (l + m) / 2, t = (6610 * l - 13613 * m + 7003 * s) / 8192, p = (17933 * l - 17390 * m - 543 * s) / 4096;
    return 720 * std::sqrt(i * i + t * t + p * p);
}
void expectDifference(const SearchBudget& budget) {
    std::vector<SearchRange> ranges(6, {1e-45, 3.4e38, Kind::Signed});
    ranges.push_back({kDiffuseWhite / kMostWhite * 1e-6, kDiffuseWhite / kLeastWhite * 1e6});
    ranges.push_back({kLeastBlack, kMostBlack});
    test::expectHolds("visibleDifference, within 1e-9", ranges, budget, [](const std::vector<double>& in) {
        const glm::dvec3 a(in[0], in[1], in[2]), b(in[3], in[4], in[5]);
        const Display display{in[6], in[7]};
        return std::abs(static_cast<Real>(visibleDifference(a, b, display)) - visibleTruth(a, b, display)) / 1e-9L;
    });
}
TEST(LightingNumbers, ExtremaOfQuadraticsHaveTheStatedErrorAtEverySize) {
    expectExtrema({4000});
}
TEST(LightingNumbers, TheCurveOfTheDisplayHasTheStatedErrorForEveryDouble) {
    expectCurve({200000});
}
TEST(LightingNumbers, VisibleDifferencesHaveTheStatedErrorForEveryLight) {
    expectDifference({60000});
}
TEST(LightingNumbersSoak, ExtremaOfQuadraticsHaveTheStatedErrorAtEverySize) {
    expectExtrema(test::soakBudget());
}
TEST(LightingNumbersSoak, TheCurveOfTheDisplayHasTheStatedErrorForEveryDouble) {
    expectCurve(test::soakBudget());
}
TEST(LightingNumbersSoak, VisibleDifferencesHaveTheStatedErrorForEveryLight) {
    expectDifference(test::soakBudget());
}

}  // namespace
}  // namespace lightcook::lighting
