#include "pipeline/graph/parallel_for.h"

#include <gtest/gtest.h>

#include <numeric>

namespace lightcook::pipeline {
namespace {

class ParallelFor : public testing::Test {
protected:
    Action action_{"cook/a", "light-map", "a", {}, {}, {}};
    SharedObjects shared_;
    RunState state_;
    ActionContext context_{action_, {}, {}, {}, shared_, state_};
};

TEST_F(ParallelFor, ResultsAreMergedInTheOrderOfTheIndices) {
    std::vector<int> merged;
    const auto folded = foldInOrder<int>(
        1000, context_, "count", [](int index) -> formats::Result<int> { return index; }, [&](int index) { merged.push_back(index); });
    ASSERT_TRUE(folded.has_value());
    std::vector<int> expected(1000);
    std::iota(expected.begin(), expected.end(), 0);
    EXPECT_EQ(merged, expected);
}

TEST_F(ParallelFor, TheErrorOfTheLowestIndexIsReturned) {
    for (int round = 0; round < 20; ++round) {
        const auto mapped = mapInOrder<int>(100, context_, "fail", [](int index) -> formats::Result<int> {
            if (index % 7 == 5) return formats::failure(formats::ErrorCode::ValueOutOfRange, std::to_string(index), "found it");
            return index;
        });
        ASSERT_FALSE(mapped.has_value());
        EXPECT_EQ(mapped.error().subject, "5");
    }
}

TEST_F(ParallelFor, APassReportsItsPartOfTheAction) {
    std::vector<double> reported;
    state_.progress = [&](const Action&, const std::string&, double fraction) { reported.push_back(fraction); };
    const auto one = [](int index) -> formats::Result<int> { return index; };
    ASSERT_TRUE(mapInOrder<int>(1, context_.between(0.25, 0.5), "second", one));
    ASSERT_TRUE(mapInOrder<int>(1, context_.between(0.75, 1).between(0, 0.5), "half of the last", one));
    ASSERT_TRUE(mapInOrder<int>(1, context_, "all", one));
    EXPECT_EQ(reported, (std::vector<double>{0.5, 0.875, 1}));
}

TEST_F(ParallelFor, AnInterruptEndsTheLoop) {
    state_.interrupted = true;
    int count = 0;
    EXPECT_FALSE(forEachIndex(10, context_, "wait", [&](std::size_t) { ++count; }));
    EXPECT_EQ(count, 0);
    const auto mapped = mapInOrder<int>(10, context_, "wait", [](int index) -> formats::Result<int> { return index; });
    ASSERT_FALSE(mapped.has_value());
    EXPECT_EQ(mapped.error().code, formats::ErrorCode::Interrupted);
}

TEST(SharedObjects, AreMadeOnceForEachType) {
    SharedObjects shared;
    shared.get<int>() = 7;
    EXPECT_EQ(shared.get<int>(), 7);
    EXPECT_EQ(shared.get<double>(), 0);
}

}  // namespace
}  // namespace lightcook::pipeline
