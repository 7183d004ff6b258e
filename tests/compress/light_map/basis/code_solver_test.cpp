#include "compress/light_map/basis/code_solver.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/compress/light_map/basis/random_basis.h"

namespace lightcook {
namespace {

using compress::BasisShape;
using compress::BasisTarget;
using compress::CodeTable;
using compress::Metric;
using CodeSpaceTest = synthetic::BasisTest;

TEST_F(CodeSpaceTest, FindsTheCodeOfTheTargetFromNearby) {
    compress::ShadingMetric metrics;
    for (int round = 0; round < 300; ++round) {
        const BasisShape shape{round % 2 == 0 ? 4 : 3, 0};
        const CodeTable table = randomTable(0.3f);
        glm::vec4 truth = randomCode();
        if (shape.codeChannels == 3) truth.w = 1;
        const Metric metric = metrics.at(randomNormal());
        BasisTarget target{{}, {1, 0.5f, 2}, &metric};
        const compress::HigherByChannel made = compress::evaluateCode(table, shape.monomialCount(), truth);
        for (std::size_t c = 0; c < 3; ++c) std::copy(made[c].begin(), made[c].end(), target.ratio[c].begin() + 1);
        glm::vec4 start = glm::clamp(truth + 0.15f * (randomCode() - 0.5f), 0.0f, 1.0f);
        if (shape.codeChannels == 3) start.w = 1;
        const compress::SolvedCode solved = compress::CodeSpace(table, shape, metric).solve(target, start);
        EXPECT_LT(solved.error, 1e-5f);
        for (int k = 0; k < shape.codeChannels; ++k) EXPECT_NEAR(solved.code[k], truth[k], 2e-2f);
    }
}

}  // namespace
}  // namespace lightcook
