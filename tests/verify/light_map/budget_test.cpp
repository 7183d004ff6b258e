// Verification takes about the same time on any light: the work of its bounds has budgets, and what is reported without tight bounds is
// still a bound.
#include <gtest/gtest.h>

#include <cmath>
#include <ctime>
#include <limits>
#include <vector>

#include "tests/compress/synthetic_light_map.h"
#include "tests/verify/visible_sampler.h"
#include "verify/assets/random.h"
#include "verify/light_map/bound_evaluator.h"
#include "verify/light_map/visible_search.h"

namespace lightcook {
namespace {

using verify::SearchBudget;
using verify::lightmap::BoundEvaluator;
using verify::lightmap::LargestBounds;

TEST(SearchBudget, GivesWhatIsLeftOfIt) {
    constexpr std::size_t kControls = 16;  // a cell costs 2, and the control vectors of a search 4
    SearchBudget budget(1000);
    EXPECT_EQ(budget.cells(kControls), 500);
    budget.spend(247, kControls);
    EXPECT_EQ(budget.cells(kControls), 251);
    budget.spend(100.0);
    EXPECT_EQ(budget.cells(kControls), 201);
    budget.spend(200, kControls);
    EXPECT_TRUE(budget.isSpent());
    EXPECT_EQ(budget.cells(kControls), 1);
    EXPECT_TRUE(SearchBudget(0).isSpent());
}

/// However many searches there are, they do not exceed the budget by more than one cell and the control vectors of the last.
TEST(SearchBudget, IsNeverExceededByMoreThanTheLastSearch) {
    SearchBudget budget(5000);
    int cells = 0;
    while (!budget.isSpent()) {
        const int each = std::min(384, budget.cells(4));
        budget.spend(each, 4);
        cells += each;
    }
    EXPECT_LE(cells, 4001);  // of 1.25 each
}

class ExactBounds : public testing::Test {
protected:
    ExactBounds() {
        setup_.responses = {{{1, 0.8, 0.5}, {0, 0.01, 0.02}}};
        setup_.largestResponse = setup_.responses[0].norms();
    }
    std::vector<verify::ErrorPair> pairs() {
        std::vector<verify::ErrorPair> out(4);
        for (verify::ErrorPair& pair : out)
            for (std::size_t i = 0; i < pair.error.size(); ++i) {
                pair.error[i] = static_cast<float>(0.02 * (random_.next() - 0.5));
                pair.reference[i] = static_cast<float>(i == 0 ? 3.0 : random_.next() - 0.5);
            }
        return out;
    }
    verify::ShadingSetup setup_;
    verify::Random random_{11};
};

TEST_F(ExactBounds, WithoutBudgetAreReplacedByLargerOnes) {
    const BoundEvaluator evaluator(setup_, 1);
    for (int i = 0; i < 50; ++i) {
        const auto some = pairs();
        LargestBounds exact, spent;
        spent.mostWork = 0;
        evaluator.raise(exact, some, {1e-4, 1e-4, 1e-4}, {1, 2});
        evaluator.raise(spent, some, {1e-4, 1e-4, 1e-4}, {1, 2});
        EXPECT_EQ(exact.work, 8);
        EXPECT_EQ(spent.work, 0);
        for (auto kind : {&LargestBounds::diffuse, &LargestBounds::specular}) {
            EXPECT_GT((exact.*kind).bound, 0);
            EXPECT_GE((spent.*kind).bound, (exact.*kind).bound);
            EXPECT_LE((spent.*kind).bound, 1000 * (exact.*kind).bound);
            EXPECT_EQ((spent.*kind).place.x, 1);
            EXPECT_EQ((spent.*kind).place.y, 2);
            EXPECT_NEAR(glm::length((spent.*kind).place.normal), 1, 1e-12);
        }
    }
}

TEST_F(ExactBounds, WithoutBudgetAreInfiniteForErrorsThatAreNot) {
    const BoundEvaluator evaluator(setup_, 1);
    for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
        auto some = pairs();
        some[2].error[5] = bad;
        LargestBounds spent;
        spent.mostWork = 0;
        evaluator.raise(spent, some, {}, {1, 2});
        EXPECT_EQ(spent.diffuse.bound, std::numeric_limits<double>::infinity());
        EXPECT_EQ(spent.specular.bound, std::numeric_limits<double>::infinity());
    }
}

double threadSeconds() {
    timespec now{};
    ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
    return static_cast<double>(now.tv_sec) + 1e-9 * static_cast<double>(now.tv_nsec);
}

/// Verifies a map, and returns the processor time [s].
double verifiedIn(formats::LightMapStrip strip) {
    const test::Cooked cooked = test::cook(std::move(strip), formats::LightMapLayout::Sh4, formats::Target::Bc, 1);
    const auto verifier = verify::LightMapVerifier::create(cooked.map, {}, {}, cooked.key, test::viewingOf(cooked));
    EXPECT_TRUE(verifier.has_value());
    const double start = threadSeconds();
    const verify::StageError total = verifier->verifyRows(cooked.texels, cooked.reference, 0, cooked.map.height).figures().back();
    const double seconds = threadSeconds() - start;
    for (const verify::ErrorFigures& figures : {total.diffuse, total.specular}) {
        EXPECT_GE(figures.maxBound.value_or(0), figures.maxSampled);
        EXPECT_TRUE(figures.visible && figures.visible->bound && *figures.visible->bound >= figures.visible->max);
    }
    return seconds;
}

/// Under even light every texel and quad has nearly the same bound. They took 16 times as long as others.
TEST(VerificationTime, IsHardlyMoreUnderEvenLight) {
    constexpr int kWidth = 96, kHeight = 64;
    const double varied = verifiedIn(synthetic::makeBand(synthetic::Kind::Gradient, kWidth, 0, kHeight));
    formats::LightMapStrip even = synthetic::makeBand(synthetic::Kind::Gradient, kWidth, 0, kHeight);
    for (int y = 0; y < kHeight; ++y)
        for (int x = 0; x < kWidth; ++x) {
            // Radiance 1 from the hemisphere of the normal.
            lighting::ShRgb& sh = even.sh.at(x, y);
            const glm::vec3 n = std::numbers::pi_v<float> * static_cast<float>(lighting::kShLinear) * even.normal.at(x, y);
            sh = {};
            sh[0] = glm::vec3(2 * std::numbers::pi_v<float> * static_cast<float>(lighting::kShConstant));
            sh[1] = glm::vec3(n.y);
            sh[2] = glm::vec3(n.z);
            sh[3] = glm::vec3(n.x);
        }
    EXPECT_LE(verifiedIn(std::move(even)), 5 * varied);
}

}  // namespace
}  // namespace lightcook
