#include "verify/light_map/bound.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include "lighting/radiometry.h"
#include "lighting/sphere.h"

namespace lightcook {
namespace {

constexpr double kFloor = lighting::kLocalErrorFloor;
constexpr std::array kExit = {verify::kExitResponse};

/// Returns the largest exit radiance over many normals.
lighting::ShBands exitSlack(double radiance) {
    return {radiance / kExit[0].norms()[0], 0, 0};
}

class Random {
public:
    double uniform() { return std::uniform_real_distribution<double>(0, 1)(engine_); }
    double gauss() { return std::normal_distribution<double>(0, 1)(engine_); }
    glm::dvec3 direction() { return glm::normalize(glm::dvec3(gauss(), gauss(), gauss())); }

    lighting::Sh error(double size) {
        lighting::Sh out;
        for (float& c : out) c = static_cast<float>(size * gauss());
        return out;
    }
    /// Returns ambient light plus a directional light of the given strength. With a strong one, the quadratic rings below zero.
    lighting::Sh light(double lamp) {
        const lighting::ShDouble basis = lighting::evaluateBasis(direction());
        lighting::Sh out;
        for (std::size_t i = 0; i < out.size(); ++i) out[i] = static_cast<float>(lamp * basis[i]);
        out[0] += static_cast<float>(uniform());
        return out;
    }

private:
    std::mt19937 engine_{17};
};

double exitRadiance(const lighting::Sh& sh, const glm::dvec3& n) {
    const lighting::ShDouble basis = lighting::evaluateBasis(n);
    double sum = 0;
    for (std::size_t i = 0; i < sh.size(); ++i)
        sum += lighting::kExitRadianceBands[static_cast<std::size_t>(lighting::kShBand[i])] * static_cast<double>(sh[i]) * basis[i];
    return sum;
}

double localError(const verify::ErrorPair& pair, const glm::dvec3& n) {
    return std::abs(exitRadiance(pair.error, n)) / (std::abs(exitRadiance(pair.reference, n)) + kFloor);
}

double sampledMaximum(const verify::ErrorPair& pair) {
    double worst = 0;
    for (int i = 0; i < 20000; ++i) worst = std::max(worst, localError(pair, lighting::fibonacciSphere(i, 20000)));
    return worst;
}

TEST(LocalErrorBound, IsTheMaximumItselfWhereTheReferenceIsNotNegative) {
    Random random;
    for (int i = 0; i < 30; ++i) {
        std::vector<verify::ErrorPair> pair = {{random.error(0.01), random.light(0.3)}};
        pair[0].reference[0] += 0.5f;  // well above the ringing of the light source
        const double bound = verify::localErrorBound(pair, kExit, kFloor, {}), sampled = sampledMaximum(pair[0]);
        EXPECT_LE(sampled, bound * (1 + 1e-9));
        EXPECT_GE(sampled, 0.999 * bound);
    }
}

TEST(LocalErrorBound, HoldsForLightThatRingsBelowZero) {
    Random random;
    for (int i = 0; i < 60; ++i) {
        const std::vector<verify::ErrorPair> pair = {{random.error(0.1), random.light(std::pow(10.0, 5 * random.uniform() - 1))}};
        const double bound = verify::localErrorBound(pair, kExit, kFloor, {});
        EXPECT_LE(sampledMaximum(pair[0]), bound * (1 + 1e-9));
        EXPECT_TRUE(std::isfinite(bound));
    }
}

TEST(LocalErrorBound, HoldsForEveryMeanOfThePairs) {
    Random random;
    for (int i = 0; i < 40; ++i) {
        std::vector<verify::ErrorPair> pairs;
        for (int k = 0; k < 9; ++k) pairs.push_back({random.error(0.05), random.light(random.uniform() < 0.5 ? 0.2 : 30)});
        const double bound = verify::localErrorBound(pairs, kExit, kFloor, {});
        for (int sample = 0; sample < 2000; ++sample) {
            // Uneven weights come closer to the extremes.
            std::vector<double> weights;
            double sum = 0;
            for (std::size_t k = 0; k < pairs.size(); ++k) sum += weights.emplace_back(std::pow(random.uniform(), 6.0));
            verify::ErrorPair mean;
            for (std::size_t k = 0; k < pairs.size(); ++k)
                for (std::size_t c = 0; c < mean.error.size(); ++c) {
                    mean.error[c] += static_cast<float>(weights[k] / sum) * pairs[k].error[c];
                    mean.reference[c] += static_cast<float>(weights[k] / sum) * pairs[k].reference[c];
                }
            ASSERT_LE(localError(mean, random.direction()), bound * (1 + 1e-5));
        }
    }
}

// Light of two signs whose mean is dark, and an error in one of them: at t = 0 the other pair fulfils any condition.
TEST(LocalErrorBound, HoldsForAPairWithoutAnErrorWhoseReferenceIsNegative) {
    std::array<verify::ErrorPair, 2> pairs{};
    pairs[0].reference[0] = -1000;
    pairs[1].reference[0] = 1000;
    pairs[1].error[0] = 100;
    verify::ErrorPair mean;
    mean.error[0] = 50;
    const double error = localError(mean, {0, 0, 1});
    EXPECT_GE(verify::localErrorBound(pairs, kExit, kFloor, {}), error);
    std::swap(pairs[0], pairs[1]);
    EXPECT_GE(verify::localErrorBound(pairs, kExit, kFloor, {}), error);
}

TEST(LocalErrorBound, StaysWithinAgreesWithTheBound) {
    Random random;
    for (int i = 0; i < 100; ++i) {
        const std::vector<verify::ErrorPair> pairs = {{random.error(0.05), random.light(1)}, {random.error(0.05), random.light(10)}};
        const double bound = verify::localErrorBound(pairs, kExit, kFloor, exitSlack(1e-6));
        EXPECT_TRUE(verify::cannotExceed(pairs, kExit, kFloor, exitSlack(1e-6), bound * (1 + 1e-9)));
        EXPECT_FALSE(verify::cannotExceed(pairs, kExit, kFloor, exitSlack(1e-6),
                                          0.5 * std::max(sampledMaximum(pairs[0]), sampledMaximum(pairs[1]))));
    }
}

TEST(LocalErrorBound, IsZeroWithoutErrorAndCountsRounding) {
    const std::vector<verify::ErrorPair> none = {{}};
    EXPECT_EQ(verify::localErrorBound(none, kExit, kFloor, {}), 0);
    EXPECT_NEAR(verify::localErrorBound(none, kExit, kFloor, exitSlack(0.01)), 0.5, 1e-9);
    EXPECT_TRUE(verify::cannotExceed(none, kExit, kFloor, {}, 0));
}

TEST(LocalErrorBound, IsInfiniteForNan) {
    for (const float value : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()})
        for (std::size_t i = 0; i < 9; ++i)
            for (const bool isError : {true, false}) {
                std::vector<verify::ErrorPair> pairs(3);
                (isError ? pairs[1].error : pairs[1].reference)[i] = value;
                EXPECT_EQ(verify::localErrorBound(pairs, kExit, kFloor, {}), std::numeric_limits<double>::infinity());
                EXPECT_FALSE(verify::cannotExceed(pairs, kExit, kFloor, {}, 1e30));
            }
}

TEST(LocalErrorBound, ExitNormsAreTheAdditionTheorem) {
    Random random;
    for (int i = 0; i < 200; ++i) {
        const lighting::Sh sh = random.error(1);
        const double bound = verify::bandSum(lighting::bandLengths(sh), verify::kExitNorm);
        EXPECT_LE(std::abs(exitRadiance(sh, random.direction())), bound * (1 + 1e-6));
    }
    // Reached by light from a single direction, in that direction.
    const glm::dvec3 n = random.direction();
    lighting::Sh delta;
    for (std::size_t i = 0; i < delta.size(); ++i) delta[i] = static_cast<float>(lighting::evaluateBasis(n)[i]);
    EXPECT_NEAR(exitRadiance(delta, n), verify::bandSum(lighting::bandLengths(delta), verify::kExitNorm), 1e-6);
}

}  // namespace
}  // namespace lightcook
