#include "compress/light_map/basis/code_solver.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "tests/compress/light_map/basis/random_basis.h"

namespace lightcook {
namespace {

using compress::BasisShape;
using compress::BasisTarget;
using compress::CodeTable;
using synthetic::cost;
using CodeSpaceTest = synthetic::BasisTest;

TEST_F(CodeSpaceTest, FindsTheCodeOfTheTargetFromNearby) {
    for (int round = 0; round < 300; ++round) {
        const BasisShape shape{round % 2 == 0 ? 4 : 3, 0};
        const CodeTable table = randomTable(0.3f);
        glm::vec4 truth = randomCode();
        if (shape.codeChannels == 3) truth.w = 1;
        BasisTarget target{{}, randomCost(round % 3 == 0)};
        const compress::HigherByChannel made = compress::evaluateCode(table, shape.monomialCount(), truth);
        for (std::size_t c = 0; c < 3; ++c) {
            target.ratio[c][0] = 1;
            std::copy(made[c].begin(), made[c].end(), target.ratio[c].begin() + 1);
        }
        glm::vec4 start = glm::clamp(truth + 0.15f * (randomCode() - 0.5f), 0.0f, 1.0f);
        if (shape.codeChannels == 3) start.w = 1;
        const compress::SolvedCode solved = compress::CodeSpace(table, shape).solve(target, start);
        EXPECT_NEAR(solved.error, 0, 1e-4f);
        for (int k = 0; k < shape.codeChannels; ++k) EXPECT_NEAR(solved.code[k], truth[k], 3e-2f);
    }
}

TEST_F(CodeSpaceTest, SearchReportsItsCostAndIsNotWorseThanAnySeed) {
    for (int round = 0; round < 100; ++round) {
        const BasisShape shape{4, 0};
        const CodeTable table = randomTable(0.3f);
        BasisTarget target{{}, randomCost(round % 2 == 0)};
        for (auto& channel : target.ratio)
            for (float& value : channel) value = uniform(-0.5f, 0.5f);
        const auto costOf = [&](const glm::vec4& code) {
            compress::ByChannel left = target.ratio;
            compress::subtractCode(compress::evaluateCode(table, shape.monomialCount(), code), left);
            return cost(target.cost, left);
        };
        std::vector<glm::vec4> seeds;
        for (int i = 0; i < 8; ++i) seeds.push_back(randomCode());
        const compress::SolvedCode solved = compress::CodeSpace(table, shape, seeds).search(target);
        const double least = costOf(solved.code);
        EXPECT_NEAR(static_cast<double>(solved.error), least, 1e-3 * least);
        for (const glm::vec4& seed : seeds) EXPECT_LE(least, costOf(seed) * 1.001);
    }
}

}  // namespace
}  // namespace lightcook
