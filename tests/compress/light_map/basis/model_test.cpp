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
using compress::Metric;
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

TEST_F(BasisModelTest, ResidualTexelsAreALeastSquaresSolution) {
    compress::ShadingMetric metrics;
    for (int round = 0; round < 300; ++round) {
        const ResidualTable table = randomResidual();
        const Metric metric = metrics.at(randomNormal());
        BasisTarget target{{}, {1, 0.3f, 3}, &metric};
        for (auto& channel : target.ratio)
            for (float& value : channel) value = uniform(-0.2f, 0.2f);
        const auto costOf = [&](const glm::vec4& texel) {
            ByChannel taken{};
            compress::addResidual(table, texel, taken);
            double sum = 0;
            for (std::size_t c = 0; c < 3; ++c) {
                std::array<double, 9> left;
                for (std::size_t i = 0; i < 9; ++i) left[i] = static_cast<double>(target.ratio[c][i] - taken[c][i]);
                sum += static_cast<double>(target.weight[c]) * cost(metric, left);
            }
            return sum;
        };
        const glm::vec4 found = compress::solveResidual(table, target);
        const bool isInside = glm::all(glm::lessThan(glm::abs(found - 0.5f), glm::vec4(0.49f)));
        if (!isInside) continue;
        const double least = costOf(found);
        for (int k = 0; k < 4; ++k)
            for (const float step : {-0.01f, 0.01f}) {
                glm::vec4 other = found;
                other[k] += step;
                EXPECT_GE(costOf(other), least * (1 - 1e-5));
            }
    }
}

}  // namespace
}  // namespace lightcook
