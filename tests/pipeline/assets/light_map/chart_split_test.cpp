#include "pipeline/assets/light_map/chart_split.h"

#include <gmock/gmock.h>

#include <array>

namespace lightcook::pipeline {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using verify::ShadedSums;

/// Returns 10000 samples of which some are above the limit, with a relative error.
ShadedSums samples(std::int64_t above, double relRms = 0) {
    const ShadedSums::Light light{10000, above, relRms * relRms, 1};
    return {light, light};
}

CandidateByGroup candidate(const std::string& layout, double bits, std::vector<ShadedSums> ofGroups) {
    CandidateByGroup made;
    made.whole.layout = layout;
    made.whole.bitsPerTexel = bits;
    made.sums = std::move(ofGroups);
    return made;
}

constexpr std::array<std::int64_t, 3> kTexels = {1000, 1000, 2000};

TEST(ChartSplit, TheWorstChartsAreLeftOutUntilTheRestKeepsTheLimit) {
    // 85 of 10000 may be above: 1 %, less the margin.
    const std::array candidates = {candidate("small", 16, {samples(300), samples(20), samples(150)}),
                                   candidate("large", 80, {samples(60), samples(0), samples(10)})};
    const ChartSplit split = chooseSplit(candidates, kTexels, {1, 5.0, 0.85}, 1);
    EXPECT_THAT(split.fine, ElementsAre(0));
    EXPECT_EQ(split.layout, "small");
    EXPECT_EQ(split.fineLayout, "large");
    EXPECT_DOUBLE_EQ(split.bits, (16 * 3000 + 80 * 1000) / 4000.0);
    EXPECT_DOUBLE_EQ(split.bitsOfOne, 80);
}

TEST(ChartSplit, OneMapIsTakenWhereItIsAsSmall) {
    const std::array every = {candidate("small", 16, {samples(50), samples(20), samples(80)}),
                              candidate("large", 80, {samples(0), samples(0), samples(0)})};
    EXPECT_THAT(chooseSplit(every, kTexels, {1, 5.0, 0.85}, 1).fine, IsEmpty());
    EXPECT_EQ(chooseSplit(every, kTexels, {1, 5.0, 0.85}, 1).layout, "small");
    const std::array none = {candidate("small", 16, {samples(500), samples(500), samples(500)}),
                             candidate("large", 80, {samples(0), samples(0), samples(0)})};
    EXPECT_THAT(chooseSplit(none, kTexels, {1, 5.0, 0.85}, 1).fine, IsEmpty()) << "no chart keeps the limit in the small layout";
    const std::array little = {candidate("small", 79, {samples(500), samples(0), samples(0)}),
                               candidate("large", 80, {samples(0), samples(0), samples(0)})};
    EXPECT_THAT(chooseSplit(little, kTexels, {1, 5.0, 0.85}, 1).fine, IsEmpty()) << "1 % is less than two maps cost";
    EXPECT_THAT(chooseSplit({}, kTexels, {1, 5.0, 0.85}, 1).fine, IsEmpty());
}

TEST(ChartSplit, TexelsBesideCutsCount) {
    const std::array candidates = {candidate("small", 16, {samples(300), samples(20), samples(150)}),
                                   candidate("large", 80, {samples(60), samples(0), samples(10)})};
    const ChartSplit split = chooseSplit(candidates, kTexels, {1, 5.0, 0.85}, 1.5);
    EXPECT_THAT(split.fine, ElementsAre(0));
    EXPECT_DOUBLE_EQ(split.bits, (16 * 3000 + 1.5 * 80 * 1000) / 4000.0);
    EXPECT_THAT(chooseSplit(candidates, kTexels, {1, 5.0, 0.85}, 4).fine, IsEmpty()) << "so many that one map is smaller";
}

/// The fine layout misses the limit on the worst tiles alone: with one that needs it less, it keeps the limit on both.
TEST(ChartSplit, MoreThanTheWorstMayBeLeftOut) {
    const std::array candidates = {candidate("small", 16, {samples(300), samples(90), samples(0)}),
                                   candidate("large", 40, {samples(120), samples(0), samples(0)}),
                                   candidate("exact", 400, {samples(0), samples(0), samples(0)})};
    const std::array<std::int64_t, 3> texels = {1000, 1000, 8000};
    const ChartSplit split = chooseSplit(candidates, texels, {1, 5.0, 0.65}, 1);
    EXPECT_EQ(split.layout, "small");
    EXPECT_EQ(split.fineLayout, "large");
    EXPECT_THAT(split.fine, ElementsAre(0, 1)) << "120 of 10000 are above 0.65 %, of 20000 they are not";
    EXPECT_DOUBLE_EQ(split.bits, 0.8 * 16 + 0.2 * 40);
}

TEST(ChartSplit, EitherLightDecides) {
    const auto specularAlone = [](std::int64_t above) { return ShadedSums{{10000, 0, 0, 1}, {10000, above, 0, 1}}; };
    const std::array candidates = {candidate("small", 16, {samples(0), specularAlone(400), samples(0)}),
                                   candidate("large", 80, {samples(0), samples(0), samples(0)})};
    EXPECT_THAT(chooseSplit(candidates, kTexels, {1, 5.0, 0.85}, 1).fine, ElementsAre(1));
}

TEST(ChartSplit, RelativeErrorsDecideWithoutAVisibleLimit) {
    const std::array candidates = {candidate("small", 16, {samples(9999, 0.01), samples(9999, 0.01), samples(9999, 0.2)}),
                                   candidate("large", 80, {samples(9999, 0.01), samples(9999, 0.01), samples(9999, 0.01)})};
    const ChartSplit split = chooseSplit(candidates, kTexels, {0.05, {}, 0.9}, 1);
    EXPECT_THAT(split.fine, ElementsAre(2));
    EXPECT_DOUBLE_EQ(split.bits, 48);
}

TEST(ChartSplit, TheLeftOutChartsMayNeedALargerLayoutThanTheWholeMap) {
    const std::array candidates = {candidate("small", 16, {samples(900), samples(0), samples(0)}),
                                   candidate("large", 80, {samples(200), samples(0), samples(0)}),
                                   candidate("exact", 100, {samples(0), samples(0), samples(0)})};
    const ChartSplit split = chooseSplit(candidates, kTexels, {1, 5.0, 0.85}, 1);
    EXPECT_THAT(split.fine, ElementsAre(0));
    EXPECT_EQ(split.fineLayout, "exact");
    EXPECT_DOUBLE_EQ(split.bitsOfOne, 80) << "200 of 30000 are within the limit";
    EXPECT_DOUBLE_EQ(split.bits, (16 * 3000 + 100 * 1000) / 4000.0);
}

}  // namespace
}  // namespace lightcook::pipeline
