#include "compress/light_map/basis/model.h"

#include <gtest/gtest.h>

#include <glm/vector_relational.hpp>

#include "shaders/lightcook_cpp.h"
#include "tests/compress/light_map/basis/random_basis.h"

namespace lightcook {
namespace {

using compress::BasisShape;
using compress::BasisTarget;
using compress::ByChannel;
using compress::CodeTable;
using compress::ResidualTable;
using synthetic::cost;
using BasisModelTest = synthetic::BasisTest;

TEST_F(BasisModelTest, DecodesAsTheShaderDoes) {
    for (int round = 0; round < 100; ++round) {
        const CodeTable table = randomTable(1);
        const ResidualTable residual = randomResidual();
        shaders::LcBasisFirst3 first3;
        shaders::LcBasisFirst4 first4;
        shaders::LcBasisResidual added;
        for (std::size_t m = 0; m < 15; ++m)
            for (std::size_t i = 0; i < 8; ++i) {
                const glm::vec3 value(table[m][0][i], table[m][1][i], table[m][2][i]);
                first4.v[8 * m + i] = value;
                if (m < 10) first3.v[8 * m + i] = value;
            }
        for (std::size_t k = 0; k < 4; ++k)
            for (std::size_t i = 0; i < 9; ++i) added.v[9 * k + i] = glm::vec3(residual[k][0][i], residual[k][1][i], residual[k][2][i]);
        const glm::vec4 l0(uniform(0, 2), uniform(0, 2), uniform(0, 2), 1), code = randomCode(), texel = randomCode();
        for (const int codes : {3, 4}) {
            const shaders::LcSh plain =
                codes == 3 ? shaders::lcLightMapBasis3(l0, code, first3, 2) : shaders::lcLightMapBasis4(l0, code, first4, 2);
            const shaders::LcSh sh = shaders::lcLightMapBasisAdd(plain, l0, texel, added, 2, compress::kResidualNeutral);
            const compress::HigherByChannel higher = compress::evaluateCode(table, BasisShape{codes, 0}.monomialCount(), code);
            ByChannel ratio{};
            for (std::size_t c = 0; c < 3; ++c) {
                ratio[c][0] = 1;
                for (std::size_t i = 0; i < 8; ++i) ratio[c][i + 1] = higher[c][i];
            }
            compress::addResidual(residual, texel, ratio);
            for (int c = 0; c < 3; ++c)
                for (std::size_t i = 0; i < 9; ++i)
                    EXPECT_NEAR(sh.c[i][c], 2 * l0[c] * ratio[static_cast<std::size_t>(c)][i], 1e-4f) << codes << ' ' << i;
        }
    }
}

TEST_F(BasisModelTest, ChannelWeightsOfAFormAreThoseOfItsCost) {
    for (int round = 0; round < 100; ++round) {
        compress::PackedForm form;
        for (auto& pair : form.part)
            for (float& value : pair) value = uniform(0, 3);
        const glm::vec3 dc(uniform(-0.5f, 2), uniform(0, 2), uniform(0, 2));
        EXPECT_EQ(compress::channelWeightsOf(form, dc), compress::RatioCost(form.unpacked(), dc).channelWeights());
    }
}

TEST_F(BasisModelTest, ResidualTexelsAreALeastSquaresSolution) {
    for (int round = 0; round < 300; ++round) {
        const ResidualTable table = randomResidual();
        BasisTarget target{{}, randomCost(round % 2 == 0)};
        for (auto& channel : target.ratio)
            for (float& value : channel) value = uniform(-0.2f, 0.2f);
        const auto costOf = [&](const glm::vec4& texel) {
            ByChannel left = target.ratio;
            compress::subtractResidual(table, texel, left);
            return cost(target.cost, left);
        };
        const glm::vec4 found = compress::solveResidual(table, target);
        const bool isInside = glm::all(glm::lessThan(glm::abs(found - 0.5f), glm::vec4(0.49f)));
        if (!isInside) continue;
        const double least = costOf(found);
        for (int k = 0; k < 4; ++k)
            for (const float step : {-0.05f, 0.05f}) {
                glm::vec4 other = found;
                other[k] += step;
                EXPECT_GE(costOf(other), least * (1 - 1e-4));
            }
    }
}

TEST_F(BasisModelTest, Coefficient0SuitsTheRatios) {
    compress::ShadingForm shading(compress::LightMapObjective{}, 1);
    for (int round = 0; round < 100; ++round) {
        // Light that the ratios fit exactly: coefficient 0 is its own.
        compress::HigherByChannel ratios;
        for (auto& channel : ratios)
            for (float& value : channel) value = uniform(-0.3f, 0.3f);
        const glm::vec3 dc(uniform(0.1f, 2), uniform(0.1f, 2), uniform(0.1f, 2));
        std::array<glm::vec3, 9> light{dc};
        for (std::size_t i = 0; i < 8; ++i) light[i + 1] = dc * glm::vec3(ratios[0][i], ratios[1][i], ratios[2][i]);
        const compress::ErrorForm form = shading.at(light, randomNormal()).unpacked();
        const glm::vec3 exact = compress::solveDc(form, light, ratios);
        for (int c = 0; c < 3; ++c) EXPECT_NEAR(exact[c], dc[c], 2e-3f * dc[c]);
        // Ratios that are wrong: the found coefficient 0 costs no more than the light's own.
        for (auto& channel : ratios)
            for (float& value : channel) value += uniform(-0.1f, 0.1f);
        const auto costOf = [&](const glm::vec3& stored) {
            ByChannel error{};
            for (std::size_t c = 0; c < 3; ++c)
                for (std::size_t i = 0; i < 9; ++i) {
                    const float ratio = i == 0 ? 1 : ratios[c][i - 1];
                    error[c][i] = light[i][static_cast<int>(c)] - stored[static_cast<int>(c)] * ratio;
                }
            return cost(compress::RatioCost(form, glm::vec3(1)), error);
        };
        EXPECT_LE(costOf(compress::solveDc(form, light, ratios)), costOf(dc));
    }
}

}  // namespace
}  // namespace lightcook
