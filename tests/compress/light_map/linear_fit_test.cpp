#include "compress/light_map/linear_fit.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <random>
#include <vector>

#include "lighting/radiometry.h"
#include "lighting/sphere.h"

namespace lightcook {
namespace {

using compress::rows::LinearExit;
using compress::rows::LinearFit;
using Light = std::array<glm::vec3, lighting::kShCount>;

class LinearFitTest : public testing::Test {
protected:
    double uniform(double low, double high) { return low + (high - low) * static_cast<double>(random_()) * 0x1p-32; }
    glm::vec3 randomNormal() { return glm::vec3(lighting::fibonacciSphere(static_cast<int>(random_() % 1000), 1000)); }
    /// Light from some directions, nowhere negative.
    Light randomLight() {
        lighting::ShRgb sum{};
        for (int i = 0; i < 3; ++i) {
            const glm::vec3 color(uniform(0.1, 1), uniform(0.1, 1), uniform(0.1, 1));
            const lighting::ShRgb one = lighting::projectDirectional(randomNormal(), color);
            for (std::size_t k = 0; k < sum.size(); ++k) sum[k] += one[k];
        }
        return sum;
    }
    std::mt19937 random_{5};
};

/// Normals of the hemisphere around one, spread evenly.
std::vector<glm::dvec3> normalsAround(const glm::vec3& normal) {
    constexpr int kCount = 2000;
    const glm::dmat3 frame = lighting::worldFromTangentFrame(glm::dvec3(normal));
    std::vector<glm::dvec3> normals;
    for (int i = 0; i < kCount; ++i) normals.push_back(frame * lighting::fibonacciHemisphere(i, kCount));
    return normals;
}

/// The light of a channel as a white surface shows it, by lighting/.
double shown(const Light& light, const glm::dvec3& n) {
    return static_cast<double>(lighting::evaluate(lighting::convolve(light, lighting::kExitRadianceBands), glm::vec3(n)).x);
}

/// Mean square of what a function loses over the hemisphere.
double costOf(const LinearExit& exit, const Light& light, const std::vector<glm::dvec3>& normals) {
    double sum = 0;
    for (const glm::dvec3& n : normals) {
        const double error = exit.constant + glm::dot(n, exit.linear) - shown(light, n);
        sum += error * error;
    }
    return sum / static_cast<double>(normals.size());
}

/// The least cost of any function: 4 x 4 normal equations over the normals.
double leastCost(const Light& light, const std::vector<glm::dvec3>& normals) {
    Eigen::Matrix4d products = Eigen::Matrix4d::Zero();
    Eigen::Vector4d right = Eigen::Vector4d::Zero();
    for (const glm::dvec3& n : normals) {
        const Eigen::Vector4d row(1, n.x, n.y, n.z);
        products += row * row.transpose();
        right += shown(light, n) * row;
    }
    const Eigen::Vector4d found = products.ldlt().solve(right);
    return costOf({found[0], glm::dvec3(found[1], found[2], found[3])}, light, normals);
}

LinearExit truncated(const Light& light) {
    const double first = 1 / (2 * std::sqrt(std::numbers::pi)), linear = 1 / std::sqrt(3 * std::numbers::pi);
    return {first * static_cast<double>(light[0].x), linear * glm::dvec3(light[3].x, light[1].x, light[2].x)};
}

TEST_F(LinearFitTest, LightWithoutBand2StaysAsItIs) {
    for (int round = 0; round < 100; ++round) {
        Light light = randomLight();
        std::fill(light.begin() + 4, light.end(), glm::vec3(0));
        const LinearFit fit(randomNormal());
        const LinearExit best = fit.best(light, 0), expected = truncated(light);
        EXPECT_NEAR(best.constant, expected.constant, 1e-6);
        EXPECT_LT(glm::length(best.linear - expected.linear), 1e-6);
        // |L1| <= 2 L0 for light that is nowhere negative.
        const LinearExit within = fit.within(best, 2.001);
        EXPECT_EQ(within.constant, best.constant);
        EXPECT_EQ(within.linear, best.linear);
    }
}

TEST_F(LinearFitTest, HasTheLeastErrorOverTheHemisphere) {
    double truncation = 0, fitted = 0;
    for (int round = 0; round < 200; ++round) {
        const Light light = randomLight();
        const glm::vec3 normal = randomNormal();
        const auto normals = normalsAround(normal);
        const double cost = costOf(LinearFit(normal).best(light, 0), light, normals), least = leastCost(light, normals);
        EXPECT_LE(cost, least * 1.001 + 1e-12);
        truncation += costOf(truncated(light), light, normals);
        fitted += cost;
    }
    EXPECT_LT(fitted, 0.6 * truncation);  // measured: 0.54
}

TEST_F(LinearFitTest, WithoutANormalBandsStayAsTheyAre) {
    const Light light = randomLight();
    const LinearExit best = LinearFit(glm::vec3(0)).best(light, 0), expected = truncated(light);
    EXPECT_NEAR(best.constant, expected.constant, 1e-6);
    EXPECT_LT(glm::length(best.linear - expected.linear), 1e-6);
}

TEST_F(LinearFitTest, NoFunctionWithinTheExtentIsClearlyBetter) {
    for (int round = 0; round < 40; ++round) {
        const Light light = randomLight();
        const glm::vec3 normal = randomNormal();
        const auto normals = normalsAround(normal);
        const LinearFit fit(normal);
        for (const double extent : {2.0, 4.0}) {
            const LinearExit found = fit.within(fit.best(light, 0), extent);
            ASSERT_GE(found.constant, 0);
            for (int axis = 0; axis < 3; ++axis) EXPECT_LE(std::abs(found.linear[axis]), extent * found.constant * (1 + 1e-9));
            const double cost = costOf(found, light, normals);
            for (int trial = 0; trial < 50; ++trial) {
                LinearExit other = found;
                other.constant *= uniform(0.8, 1.25);
                for (int axis = 0; axis < 3; ++axis) {
                    other.linear[axis] += uniform(-0.3, 0.3) * found.constant;
                    other.linear[axis] = std::clamp(other.linear[axis], -extent * other.constant, extent * other.constant);
                }
                EXPECT_LE(cost, 1.02 * costOf(other, light, normals));
            }
        }
    }
}

TEST_F(LinearFitTest, TheRestIsSolvedForAGivenPart) {
    for (int round = 0; round < 50; ++round) {
        const Light light = randomLight();
        const glm::vec3 normal = randomNormal();
        const auto normals = normalsAround(normal);
        const LinearFit fit(normal);
        const LinearExit best = fit.best(light, 0);
        const double constant = best.constant * uniform(0.9, 1.1);
        const LinearExit forConstant{constant, fit.linearFor(best, constant)};
        const glm::dvec3 slope(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
        const double forSlope = fit.constantFor(best, slope);
        for (int trial = 0; trial < 20; ++trial) {
            LinearExit other = forConstant;
            other.linear += 0.05 * glm::dvec3(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
            EXPECT_LE(costOf(forConstant, light, normals), 1.002 * costOf(other, light, normals));
            const double changed = forSlope * uniform(0.95, 1.05);
            EXPECT_LE(costOf({forSlope, forSlope * slope}, light, normals), 1.002 * costOf({changed, changed * slope}, light, normals));
        }
    }
}

/// Light of one direction in three strengths: the functions that share a slope lose nothing.
TEST_F(LinearFitTest, ColoursOfOneDirectionShareTheirSlope) {
    for (int round = 0; round < 50; ++round) {
        Light light = randomLight();
        for (glm::vec3& coefficient : light) coefficient = coefficient.x * glm::vec3(1.0f, 0.5f, 0.125f);
        const LinearFit fit(randomNormal());
        const auto best = fit.best(light);
        if (!(best[0].constant > 0)) continue;
        const glm::dvec3 constants(best[0].constant, best[1].constant, best[2].constant);
        const auto shared = fit.shared(best, constants, {glm::dvec3(-1e3), glm::dvec3(1e3)});
        for (std::size_t c = 0; c < 3; ++c) {
            const auto channel = static_cast<glm::dvec3::length_type>(c);
            EXPECT_NEAR(shared.constant[channel], best[c].constant, 1e-6 * best[0].constant);
            EXPECT_LT(glm::length(shared.constant[channel] * shared.slope - best[c].linear), 1e-5 * glm::length(best[0].linear));
        }
    }
}

TEST_F(LinearFitTest, NoSharedSlopeWithinItsRangeIsClearlyBetter) {
    const compress::rows::SlopeRange range{glm::dvec3(-2, -1.5, -2), glm::dvec3(2, 2, 1)};
    for (int round = 0; round < 30; ++round) {
        const Light light = randomLight();
        const glm::vec3 normal = randomNormal();
        const auto normals = normalsAround(normal);
        const LinearFit fit(normal);
        const auto best = fit.best(light);
        glm::dvec3 start;
        for (int c = 0; c < 3; ++c) start[c] = fit.within(best[static_cast<std::size_t>(c)], 2).constant;
        const auto shared = fit.shared(best, start, range);
        const auto cost = [&](const glm::dvec3& constants, const glm::dvec3& slope) {
            double sum = 0;
            for (int c = 0; c < 3; ++c) {
                Light channel = light;
                for (glm::vec3& coefficient : channel) coefficient = glm::vec3(coefficient[c]);
                sum += costOf({constants[c], constants[c] * slope}, channel, normals);
            }
            return sum;
        };
        for (int axis = 0; axis < 3; ++axis) {
            EXPECT_GE(shared.slope[axis], range.low[axis]);
            EXPECT_LE(shared.slope[axis], range.high[axis]);
        }
        const double found = cost(shared.constant, shared.slope);
        for (int trial = 0; trial < 20; ++trial) {
            glm::dvec3 slope = shared.slope, constants;
            for (int axis = 0; axis < 3; ++axis)
                slope[axis] = std::clamp(slope[axis] + uniform(-0.05, 0.05), range.low[axis], range.high[axis]);
            for (int c = 0; c < 3; ++c) constants[c] = shared.constant[c] * uniform(0.98, 1.02);
            EXPECT_LE(found, 1.03 * cost(constants, slope));
        }
    }
}

}  // namespace
}  // namespace lightcook
