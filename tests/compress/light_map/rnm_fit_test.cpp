#include "compress/light_map/rnm_fit.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>
#include <span>
#include <utility>

#include "lighting/sh.h"

namespace lightcook::compress::rows {
namespace {

using glm::dvec3;

/// The basis of Half-Life 2 in (tangent, bitangent up the picture, normal).
const std::array<dvec3, 3> kRnmBasis = {dvec3(std::sqrt(2.0 / 3), 0, 1 / std::sqrt(3.0)),
                                        dvec3(-1 / std::sqrt(6.0), -1 / std::sqrt(2.0), 1 / std::sqrt(3.0)),
                                        dvec3(-1 / std::sqrt(6.0), 1 / std::sqrt(2.0), 1 / std::sqrt(3.0))};
constexpr int kRnmNormals = 20000;

dvec3 weightsAt(const dvec3& n) {
    return {std::max(0.0, glm::dot(kRnmBasis[0], n)), std::max(0.0, glm::dot(kRnmBasis[1], n)), std::max(0.0, glm::dot(kRnmBasis[2], n))};
}

/// Pseudorandom numbers in [0, 1).
class Numbers {
public:
    explicit Numbers(std::uint64_t seed) : state_(seed) {}
    double next() {
        state_ = state_ * 6364136223846793005u + 1442695040888963407u;
        return static_cast<double>(state_ >> 11) * 0x1p-53;
    }

private:
    std::uint64_t state_;
};

/// The normal equations, summed over the ring of normals.
struct Equations {
    std::array<std::array<double, 3>, 3> g{};
    dvec3 h{0};
    double square = 0;  ///< mean of E^2
    explicit Equations(const lighting::ShDouble& light) {
        lighting::ShDouble exit = light;
        for (std::size_t i = 0; i < 9; ++i) exit[i] *= lighting::kExitRadianceBands[static_cast<std::size_t>(lighting::kShBand[i])];
        for (int k = 0; k < kRnmNormals; ++k) {
            const double z = 0.5 + 0.4 * (k + 0.5) / kRnmNormals, r = std::sqrt(1 - z * z),
                         azimuth = k * std::numbers::pi * (3 - std::sqrt(5.0));
            const dvec3 n(r * std::cos(azimuth), r * std::sin(azimuth), z), w = weightsAt(n);
            const lighting::ShDouble basis = lighting::evaluateBasis(n);
            double shown = 0;
            for (std::size_t i = 0; i < 9; ++i) shown += exit[i] * basis[i];
            h += w * shown / static_cast<double>(kRnmNormals);
            square += shown * shown / kRnmNormals;
            for (int i = 0; i < 3; ++i)
                for (int j = 0; j < 3; ++j) g[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] += w[i] * w[j] / kRnmNormals;
        }
    }
    double cost(const dvec3& r) const {
        double sum = -2 * glm::dot(h, r);
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) sum += g[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] * r[i] * r[j];
        return sum;
    }
    /// Minimizes the cost by one number after another, which converges for a convex function with limits on single numbers.
    dvec3 best(int known, dvec3 r) const {
        for (int round = 0; round < 2000; ++round)
            for (int i = known; i < 3; ++i) {
                const auto at = static_cast<std::size_t>(i);
                double rest = h[i];
                for (int j = 0; j < 3; ++j)
                    if (j != i) rest -= g[at][static_cast<std::size_t>(j)] * r[j];
                r[i] = std::max(0.0, rest / g[at][at]);
            }
        return r;
    }
};

lighting::ShDouble randomLight(Numbers& random, bool isStrange) {
    lighting::ShDouble light{};
    // A few lights, and coefficients that are no light.
    for (int i = 0; i < 3; ++i) {
        const double z = 2 * random.next() - 1, r = std::sqrt(1 - z * z), azimuth = 2 * std::numbers::pi * random.next(),
                     size = random.next();
        const lighting::ShDouble basis = lighting::evaluateBasis(dvec3(r * std::cos(azimuth), r * std::sin(azimuth), z));
        for (std::size_t k = 0; k < 9; ++k) light[k] += size * basis[k];
    }
    for (double& coefficient : light)
        if (isStrange) coefficient += 2 * random.next() - 1;
    return light;
}

TEST(RnmFit, IsTheNonnegativeLeastSquaresOverTheRing) {
    Numbers random(3);
    int clamped = 0;
    for (int trial = 0; trial < 120; ++trial) {
        const lighting::ShDouble light = randomLight(random, trial % 3 == 0);
        const Equations truth(light);
        const RnmFit fit(light);
        const dvec3 best = fit.best();
        for (int i = 0; i < 3; ++i) {
            EXPECT_GE(best[i], 0);
            clamped += best[i] == 0;
        }
        const dvec3 expected = truth.best(0, dvec3(0));
        EXPECT_NEAR(glm::length(best - expected), 0, 2e-4 * (1 + glm::length(expected)));
        EXPECT_NEAR(fit.cost(best), truth.cost(best), 1e-4 * (1 + truth.square));
        // No light near it is better.
        for (int i = 0; i < 20; ++i) {
            const dvec3 other = glm::max(best + 0.1 * (dvec3(random.next(), random.next(), random.next()) - 0.5), 0.0);
            EXPECT_GE(truth.cost(other), truth.cost(best) - 1e-6 * (1 + truth.square));
        }
    }
    EXPECT_GT(clamped, 20) << "the limits must be tried";
}

TEST(RnmFit, TheLightThatIsLeftIsTheBestForTheDecodedOne) {
    Numbers random(4);
    for (int trial = 0; trial < 60; ++trial) {
        const lighting::ShDouble light = randomLight(random, trial % 3 == 0);
        const Equations truth(light);
        const std::array<double, 2> decoded = {random.next(), random.next()};
        for (std::size_t known = 1; known <= 2; ++known) {
            const dvec3 best = RnmFit(light).best(std::span(decoded).first(known));
            dvec3 start(decoded[0], known > 1 ? decoded[1] : 0, 0);
            const dvec3 expected = truth.best(static_cast<int>(known), start);
            for (std::size_t i = 0; i < known; ++i) EXPECT_EQ(best[static_cast<int>(i)], decoded[i]);
            EXPECT_NEAR(glm::length(best - expected), 0, 2e-4 * (1 + glm::length(expected)));
        }
    }
}

/// Light that the three directions can show comes back.
TEST(RnmFit, OrderOneLightFromTheBasisIsHardlyChanged) {
    const dvec3 stored(1, 0.5, 0.25);
    // E = sum of b_i . n R_i where no direction is clamped: n . v with v = sum of b_i R_i.
    dvec3 v(0);
    for (int i = 0; i < 3; ++i) v += stored[i] * kRnmBasis[static_cast<std::size_t>(i)];
    lighting::ShDouble light{};
    for (const auto& [coefficient, along] : {std::pair(1, v.y), std::pair(2, v.z), std::pair(3, v.x)})
        light[static_cast<std::size_t>(coefficient)] = along / (2.0 / 3 * 0.4886025119029199);
    const dvec3 best = RnmFit(light).best();
    EXPECT_GT(best.x, best.y);
    EXPECT_GT(best.y, best.z);
    EXPECT_NEAR(glm::length(best - stored), 0, 0.5);
}

}  // namespace
}  // namespace lightcook::compress::rows
