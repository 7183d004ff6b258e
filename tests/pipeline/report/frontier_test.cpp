// The allocations of a scene as the report has them.
#include "pipeline/report/frontier.h"

#include <gmock/gmock.h>

namespace lightcook::pipeline {
namespace {

using testing::ElementsAre;
using testing::Field;

ReportRow rowOf(std::uint64_t bytes, std::optional<double> wholeVisible = {}) {
    ReportRow row;
    row.bytesGpu = bytes;
    if (wholeVisible) row.whole.emplace().visible.p99 = *wholeVisible;
    return row;
}
const std::vector<AllocatedLayout> kAllocated = {{"map", "basis-4+lit@5.65685"}};

/// A trial estimates the bytes of detail and the error: the scene that was cooked may beat the one that was thought to be smaller.
TEST(CookedFrontier, HasTheCookedSceneAndNoneThatItBeats) {
    const std::vector<FrontierPoint> points = {{2800, 5.6, false, kAllocated},
                                               {3400, 5.3, false, kAllocated},
                                               {3430, 3.4, true, kAllocated},
                                               {3500, 3.5, false, kAllocated},
                                               {4300, 2.8, false, kAllocated}};
    const auto cooked = asCooked(points, {rowOf(3200, 3.6), rowOf(170)});
    EXPECT_THAT(cooked, ElementsAre(Field(&FrontierPoint::bytesGpu, 2800), Field(&FrontierPoint::bytesGpu, 3370),
                                    Field(&FrontierPoint::bytesGpu, 3500), Field(&FrontierPoint::bytesGpu, 4300)));
    EXPECT_TRUE(cooked[1].isChosen);
    EXPECT_EQ(cooked[1].visible, 3.6);
}

TEST(CookedFrontier, IsThatOfTheTrialsWhereTheWholeWasNotVerified) {
    const std::vector<FrontierPoint> points = {{2800, 5.6, true, kAllocated}, {3400, 5.3, false, kAllocated}};
    EXPECT_EQ(asCooked(points, {rowOf(3200)})[0].bytesGpu, 2800);
    EXPECT_TRUE(asCooked({}, {rowOf(3200, 3.6)}).empty());
}

TEST(CookedFrontier, IsToldWithoutTheNamesOfTrials) {
    EXPECT_EQ(layoutWords({2800, 5.6, true, kAllocated}), "map: basis-4, detail above 5.7");
}

}  // namespace
}  // namespace lightcook::pipeline
