#include "compress/light_map/shading_form.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "lighting/brdf.h"
#include "lighting/radiometry.h"
#include "lighting/sphere.h"

namespace lightcook {
namespace {

using compress::ErrorForm;
using compress::LightMapObjective;
using compress::ShadingForm;
using Light = std::array<glm::vec3, lighting::kShCount>;

class ShadingFormTest : public testing::Test {
protected:
    float uniform(float low, float high) { return low + (high - low) * static_cast<float>(random_()) * 0x1p-32f; }
    glm::vec3 randomNormal() { return glm::vec3(lighting::fibonacciSphere(static_cast<int>(random_() % 1000), 1000)); }
    Light randomLight(float scale) {
        Light out;
        for (glm::vec3& value : out) value = scale * glm::vec3(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1));
        return out;
    }
    /// Light that is positive from everywhere.
    Light brightLight() {
        Light out = randomLight(0.05f);
        out[0] = glm::vec3(uniform(0.5f, 2), uniform(0.5f, 2), uniform(0.5f, 2));
        return out;
    }

    std::mt19937 random_{11};
};

double cost(const ErrorForm& form, const Light& error) {
    double sum = 0;
    for (std::size_t c = 0; c < 3; ++c)
        for (std::size_t d = 0; d < 3; ++d)
            for (std::size_t i = 0; i < 9; ++i)
                for (std::size_t j = 0; j < 9; ++j)
                    sum += static_cast<double>(form.of(c, d)[i][j] * error[i][static_cast<int>(c)]) *
                           static_cast<double>(error[j][static_cast<int>(d)]);
    return sum;
}

Light turned(const Light& light, const glm::vec3& normal) {
    const lighting::ShRotation turn(lighting::worldFromTangentFrame(glm::dvec3(normal)));
    Light out;
    for (int c = 0; c < 3; ++c) {
        lighting::ShDouble channel;
        for (std::size_t i = 0; i < channel.size(); ++i) channel[i] = static_cast<double>(light[i][c]);
        channel = turn.apply(channel);
        for (std::size_t i = 0; i < channel.size(); ++i) out[i][c] = static_cast<float>(channel[i]);
    }
    return out;
}

TEST_F(ShadingFormTest, TurnsWithTheNormal) {
    for (const bool isVisible : {false, true}) {
        ShadingForm shading(isVisible ? std::optional(LightMapObjective{}) : std::nullopt, 1);
        for (int round = 0; round < 50; ++round) {
            const glm::vec3 up(0, 0, 1), normal = randomNormal();
            const Light light = brightLight(), error = randomLight(0.1f);
            // The frame of z is not the world's: both sides are turned.
            const double expected = cost(shading.at(turned(light, up), up).unpacked(), turned(error, up));
            const double found = cost(shading.at(turned(light, normal), normal).unpacked(), turned(error, normal));
            EXPECT_GT(expected, 0);
            EXPECT_NEAR(found, expected, 2e-4 * expected);
        }
    }
}

TEST_F(ShadingFormTest, EnergyOfConstantLightIsThatOfNormalsAndMaterials) {
    // Y0^2 from the normals, and Y0^2 from the materials, which are relative to it.
    const ErrorForm form = ShadingForm(std::nullopt, 1).at(brightLight(), glm::vec3(0, 0, 1)).unpacked();
    for (std::size_t c = 0; c < 3; ++c)
        EXPECT_NEAR(static_cast<double>(form.of(c, c)[0][0]), 2 * lighting::kShConstant * lighting::kShConstant, 1e-6);
    EXPECT_EQ(form.of(0, 1)[0][0], 0);
}

/// Mean squared visible error over the objective's shadings, by the formulas of lighting/.
double meanSquare(const LightMapObjective& objective, const Light& reference, const Light& found, const glm::vec3& normal) {
    const glm::dmat3 frame = lighting::worldFromTangentFrame(glm::dvec3(normal));
    const lighting::ShRotation toWorld(frame);
    std::vector<lighting::ShDouble> rows;
    for (int i = 0; i <= 24; ++i) {
        const double z = i == 0 ? 1 : 1 - (1 - std::cos(objective.normalMapTilt * std::numbers::pi / 180)) * (i - 0.5) / 24;
        const double r = std::sqrt(1 - z * z), turn = (i - 1) * std::numbers::pi * (3 - std::sqrt(5.0));
        lighting::ShDouble row = lighting::evaluateBasis(frame * glm::dvec3(r * std::cos(turn), r * std::sin(turn), z));
        for (std::size_t c = 0; c < row.size(); ++c) row[c] *= lighting::kExitRadianceBands[static_cast<std::size_t>(lighting::kShBand[c])];
        rows.push_back(row);
    }
    for (int i = 0; i < 8; ++i)
        for (const double m : objective.m) {
            const glm::dvec3 view = lighting::fibonacciHemisphere(i, 8);
            const double length = std::hypot(view.x, view.y);
            const lighting::ShRotation around(
                glm::dmat3(glm::dvec3(view.x, view.y, 0) / length, glm::dvec3(-view.y, view.x, 0) / length, glm::dvec3(0, 0, 1)));
            const auto kernel = lighting::integrateAreaSpecular(view.z, m, objective.lobe, lighting::CookTorranceNormalization::Energy, 48);
            lighting::ShDouble row;
            for (std::size_t c = 0; c < row.size(); ++c)
                row[c] = objective.f0.back() * kernel.c[c] + (1 - objective.f0.back()) * kernel.d[c];
            rows.push_back(toWorld.apply(around.apply(row)));
        }
    double sum = 0;
    for (const lighting::ShDouble& row : rows) {
        glm::dvec3 a(0), b(0);
        for (std::size_t i = 0; i < row.size(); ++i) {
            a += row[i] * glm::dvec3(reference[i]);
            b += row[i] * glm::dvec3(found[i]);
        }
        const double difference = lighting::visibleDifference(a, b, objective.display, objective.bt2020FromWorking);
        sum += difference * difference;
    }
    return sum / static_cast<double>(rows.size());
}

TEST_F(ShadingFormTest, IsTheMeanSquareOfSmallVisibleErrors) {
    LightMapObjective objective;
    objective.display.nitsPerUnit = 150;
    ShadingForm shading(objective, 1);
    for (int round = 0; round < 30; ++round) {
        const glm::vec3 normal = randomNormal();
        const Light light = brightLight(), error = randomLight(1e-3f);
        Light found = light;
        for (std::size_t i = 0; i < found.size(); ++i) found[i] += error[i];
        // Slopes are taken where the light is brighter by a fifth of the response to coefficient 0, so costs are lower; a tenth of the mean
        // cost is added in every direction.
        const double expected = meanSquare(objective, light, found, normal);
        EXPECT_NEAR(cost(shading.at(light, normal).unpacked(), error) / expected, 0.85, 0.2);
    }
}

TEST_F(ShadingFormTest, DarkLightCostsMore) {
    ShadingForm shading(LightMapObjective{}, 1);
    const glm::vec3 up(0, 0, 1);
    Light light = brightLight(), dark = light;
    for (glm::vec3& value : dark) value *= 0.01f;
    const Light error = randomLight(1e-3f);
    EXPECT_GT(cost(shading.at(dark, up).unpacked(), error), 100 * cost(shading.at(light, up).unpacked(), error));
}

/// Beyond the brightest light of a display an error costs in proportion to the light, and by its energy.
TEST_F(ShadingFormTest, LightBeyondTheDisplayCostsInProportionAndByItsEnergy) {
    const auto costOf = [&](float dc, double lightSquare) {
        std::array<glm::vec3, 9> light{};
        light[0] = glm::vec3(dc);
        const ErrorForm form = ShadingForm(LightMapObjective{}, 1, lightSquare).at(light, glm::vec3(0, 0, 1)).unpacked();
        double sum = 0;
        for (std::size_t c = 0; c < 3; ++c) sum += static_cast<double>(1e-4f * dc * dc * form.of(c, c)[0][0]);
        return sum;
    };
    const double bright = costOf(1e5f, 0), brighter = costOf(1e7f, 0);
    EXPECT_GT(bright, 0);
    EXPECT_NEAR(brighter, bright, 0.01 * bright);
    // An error of 1 % of the RMS in each channel: 1e-4 of the share of 1000.
    EXPECT_NEAR(costOf(1e7f, 1e14) - brighter, 0.1, 0.01);
}

TEST_F(ShadingFormTest, LightBelowZeroIsHidden) {
    ShadingForm shading(LightMapObjective{}, 1);
    Light black{};
    black[0] = glm::vec3(-0.5f);
    Light zero{};
    zero[0] = glm::vec3(1e-4f);
    const Light error = randomLight(1e-3f);
    const glm::vec3 up(0, 0, 1);
    EXPECT_LT(cost(shading.at(black, up).unpacked(), error), 0.05 * cost(shading.at(zero, up).unpacked(), error));
}

}  // namespace
}  // namespace lightcook
