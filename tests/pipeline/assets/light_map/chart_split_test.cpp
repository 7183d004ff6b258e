#include "pipeline/assets/light_map/chart_split.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <random>
#include <set>
#include <tuple>

namespace lightcook::pipeline {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::UnorderedElementsAreArray;
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

/// Returns the groups of the finer of two maps; none where there is one.
std::vector<std::size_t> fineOf(const ChartSplit& split) {
    EXPECT_LE(split.parts.size(), 2u);
    return split.parts.size() == 2 ? split.parts.back().groups : std::vector<std::size_t>();
}

constexpr std::array<std::int64_t, 3> kTexels = {1000, 1000, 2000};

TEST(ChartSplit, TheWorstChartsAreLeftOutUntilTheRestKeepsTheLimit) {
    // 85 of 10000 may be above: 1 %, less the margin.
    const std::array candidates = {candidate("small", 16, {samples(300), samples(20), samples(150)}),
                                   candidate("large", 80, {samples(60), samples(0), samples(10)})};
    const ChartSplit split = chooseSplit(candidates, kTexels, {1, 5.0, 0.85}, 1, 2);
    EXPECT_THAT(fineOf(split), ElementsAre(0));
    EXPECT_EQ(split.parts.front().layout, "small");
    EXPECT_EQ(split.parts.back().layout, "large");
    EXPECT_DOUBLE_EQ(split.bits, (16 * 3000 + 80 * 1000) / 4000.0);
    EXPECT_DOUBLE_EQ(split.bitsOfOne, 80);
}

TEST(ChartSplit, OneMapIsTakenWhereItIsAsSmall) {
    const std::array every = {candidate("small", 16, {samples(50), samples(20), samples(80)}),
                              candidate("large", 80, {samples(0), samples(0), samples(0)})};
    EXPECT_THAT(fineOf(chooseSplit(every, kTexels, {1, 5.0, 0.85}, 1, 2)), IsEmpty());
    EXPECT_EQ(chooseSplit(every, kTexels, {1, 5.0, 0.85}, 1, 2).parts.front().layout, "small");
    const std::array none = {candidate("small", 16, {samples(500), samples(500), samples(500)}),
                             candidate("large", 80, {samples(0), samples(0), samples(0)})};
    EXPECT_THAT(fineOf(chooseSplit(none, kTexels, {1, 5.0, 0.85}, 1, 2)), IsEmpty()) << "no chart keeps the limit in the small layout";
    const std::array little = {candidate("small", 79, {samples(500), samples(0), samples(0)}),
                               candidate("large", 80, {samples(0), samples(0), samples(0)})};
    EXPECT_THAT(fineOf(chooseSplit(little, kTexels, {1, 5.0, 0.85}, 1, 2)), IsEmpty()) << "1 % is less than two maps cost";
    EXPECT_THAT(fineOf(chooseSplit({}, kTexels, {1, 5.0, 0.85}, 1, 2)), IsEmpty());
}

TEST(ChartSplit, TexelsBesideCutsCount) {
    const std::array candidates = {candidate("small", 16, {samples(300), samples(20), samples(150)}),
                                   candidate("large", 80, {samples(60), samples(0), samples(10)})};
    const ChartSplit split = chooseSplit(candidates, kTexels, {1, 5.0, 0.85}, 1.5, 2);
    EXPECT_THAT(fineOf(split), ElementsAre(0));
    EXPECT_DOUBLE_EQ(split.bits, (16 * 3000 + 1.5 * 80 * 1000) / 4000.0);
    EXPECT_THAT(fineOf(chooseSplit(candidates, kTexels, {1, 5.0, 0.85}, 4, 2)), IsEmpty()) << "so many that one map is smaller";
}

/// The fine layout misses the limit on the worst tiles alone: with one that needs it less, it keeps the limit on both.
TEST(ChartSplit, MoreThanTheWorstMayBeLeftOut) {
    const std::array candidates = {candidate("small", 16, {samples(300), samples(90), samples(0)}),
                                   candidate("large", 40, {samples(120), samples(0), samples(0)}),
                                   candidate("exact", 400, {samples(0), samples(0), samples(0)})};
    const std::array<std::int64_t, 3> texels = {1000, 1000, 8000};
    const ChartSplit split = chooseSplit(candidates, texels, {1, 5.0, 0.65}, 1, 2);
    EXPECT_EQ(split.parts.front().layout, "small");
    EXPECT_EQ(split.parts.back().layout, "large");
    EXPECT_THAT(fineOf(split), ElementsAre(0, 1)) << "120 of 10000 are above 0.65 %, of 20000 they are not";
    EXPECT_DOUBLE_EQ(split.bits, 0.8 * 16 + 0.2 * 40);
}

TEST(ChartSplit, EitherLightDecides) {
    const auto specularAlone = [](std::int64_t above) { return ShadedSums{{10000, 0, 0, 1}, {10000, above, 0, 1}}; };
    const std::array candidates = {candidate("small", 16, {samples(0), specularAlone(400), samples(0)}),
                                   candidate("large", 80, {samples(0), samples(0), samples(0)})};
    EXPECT_THAT(fineOf(chooseSplit(candidates, kTexels, {1, 5.0, 0.85}, 1, 2)), ElementsAre(1));
}

TEST(ChartSplit, RelativeErrorsDecideWithoutAVisibleLimit) {
    const std::array candidates = {candidate("small", 16, {samples(9999, 0.01), samples(9999, 0.01), samples(9999, 0.2)}),
                                   candidate("large", 80, {samples(9999, 0.01), samples(9999, 0.01), samples(9999, 0.01)})};
    const ChartSplit split = chooseSplit(candidates, kTexels, {0.05, {}, 0.9}, 1, 2);
    EXPECT_THAT(fineOf(split), ElementsAre(2));
    EXPECT_DOUBLE_EQ(split.bits, 48);
}

TEST(ChartSplit, TheLeftOutChartsMayNeedALargerLayoutThanTheWholeMap) {
    const std::array candidates = {candidate("small", 16, {samples(900), samples(0), samples(0)}),
                                   candidate("large", 80, {samples(200), samples(0), samples(0)}),
                                   candidate("exact", 100, {samples(0), samples(0), samples(0)})};
    const ChartSplit split = chooseSplit(candidates, kTexels, {1, 5.0, 0.85}, 1, 2);
    EXPECT_THAT(fineOf(split), ElementsAre(0));
    EXPECT_EQ(split.parts.back().layout, "exact");
    EXPECT_DOUBLE_EQ(split.bitsOfOne, 80) << "200 of 30000 are within the limit";
    EXPECT_DOUBLE_EQ(split.bits, (16 * 3000 + 100 * 1000) / 4000.0);
}

TEST(ChartSplit, AThirdMapIsMadeWhereItSavesAsMuchAsASecond) {
    const std::array candidates = {candidate("small", 16, {samples(900), samples(900), samples(0), samples(0)}),
                                   candidate("middle", 40, {samples(900), samples(10), samples(0), samples(0)}),
                                   candidate("large", 144, {samples(0), samples(0), samples(0), samples(0)})};
    const std::array<std::int64_t, 4> texels = {500, 1500, 1000, 7000};
    const ChartSplit two = chooseSplit(candidates, texels, {1, 5.0, 0.85}, 1, 2),
                     three = chooseSplit(candidates, texels, {1, 5.0, 0.85}, 1, 3);
    EXPECT_THAT(fineOf(two), ElementsAre(0, 1));
    ASSERT_EQ(three.parts.size(), 3u);
    for (const auto& [part, layout, groups] :
         {std::tuple(0, "small", std::vector<std::size_t>{2, 3}), std::tuple(1, "middle", std::vector<std::size_t>{1}),
          std::tuple(2, "large", std::vector<std::size_t>{0})}) {
        EXPECT_EQ(three.parts[static_cast<std::size_t>(part)].layout, layout);
        EXPECT_THAT(three.parts[static_cast<std::size_t>(part)].groups, UnorderedElementsAreArray(groups));
    }
    EXPECT_DOUBLE_EQ(two.bits, 0.8 * 16 + 0.2 * 144);
    EXPECT_DOUBLE_EQ(three.bits, 0.8 * 16 + 0.15 * 40 + 0.05 * 144);
    EXPECT_DOUBLE_EQ(three.bitsOfOne, 144);

    const std::array<std::int64_t, 4> few = {1900, 100, 1000, 7000};
    EXPECT_EQ(chooseSplit(candidates, few, {1, 5.0, 0.85}, 1, 3).parts.size(), 2u) << "1 % of the texels for 40 in place of 144 bits";
}

/// Memory of all texels of the best division into three maps, by trying each one [bits].
double leastInThree(std::span<const CandidateByGroup> candidates, std::span<const std::int64_t> texels, std::int64_t mostAbove) {
    double least = HUGE_VAL;
    std::size_t divisions = 1;
    for (std::size_t i = 0; i < texels.size(); ++i) divisions *= 3;
    for (std::size_t division = 0; division < divisions; ++division)
        for (std::size_t a = 0; a < candidates.size(); ++a)
            for (std::size_t b = a + 1; b < candidates.size(); ++b)
                for (std::size_t c = b + 1; c < candidates.size(); ++c) {
                    const std::array layouts = {&candidates[a], &candidates[b], &candidates[c]};
                    std::array<std::int64_t, 3> above{}, count{};
                    double bits = 0;
                    for (std::size_t group = 0, rest = division; group < texels.size(); ++group, rest /= 3) {
                        above[rest % 3] += layouts[rest % 3]->sums[group].diffuse.above;
                        count[rest % 3] += layouts[rest % 3]->sums[group].diffuse.count;
                        bits += layouts[rest % 3]->whole.bitsPerTexel * static_cast<double>(texels[group]);
                    }
                    bool keeps = true;
                    for (std::size_t map = 0; map < 3; ++map)
                        keeps = keeps && count[map] > 0 && 10000 * above[map] <= mostAbove * count[map];
                    if (keeps) least = std::min(least, bits);
                }
    return least;
}

TEST(ChartSplit, ThreeMapsAreNearTheBestOfAllDivisions) {
    std::mt19937 random(7);
    double sum = 0, leastSum = 0;
    int found = 0;
    for (int round = 0; round < 200; ++round) {
        std::vector<std::int64_t> texels;
        std::vector<CandidateByGroup> candidates = {candidate("small", 16, {}), candidate("middle", 34, {}), candidate("large", 72, {}),
                                                    candidate("exact", 144, {})};
        for (int group = 0; group < 6; ++group) {
            texels.push_back(500 + random() % 2000);
            std::int64_t above = random() % 1200;
            for (CandidateByGroup& each : candidates) {
                each.sums.push_back(samples(above));
                above = each.whole.layout == "large" ? 0 : above / (2 + random() % 4);
            }
        }
        const ChartSplit two = chooseSplit(candidates, texels, {1, 5.0, 1}, 1, 2),
                         three = chooseSplit(candidates, texels, {1, 5.0, 1}, 1, 3);
        EXPECT_LE(three.bits, two.bits);
        if (three.parts.size() < 3) continue;
        ++found;
        double bits = 0;
        std::set<std::size_t> groups;
        for (const SplitPart& part : three.parts) {
            const auto layout = std::ranges::find(candidates, part.layout, [](const CandidateByGroup& each) { return each.whole.layout; });
            std::int64_t above = 0;
            for (const std::size_t group : part.groups) {
                groups.insert(group);
                above += layout->sums[group].diffuse.above;
                bits += layout->whole.bitsPerTexel * static_cast<double>(texels[group]);
            }
            EXPECT_LE(above, 100 * static_cast<std::int64_t>(part.groups.size())) << "1 % of 10000 samples a group";
        }
        EXPECT_EQ(groups.size(), texels.size());
        const auto all = static_cast<double>(std::accumulate(texels.begin(), texels.end(), std::int64_t{0}));
        EXPECT_NEAR(three.bits * all, bits, 1e-6 * bits);
        sum += bits;
        leastSum += leastInThree(candidates, texels, 100);
    }
    EXPECT_GT(found, 10);
    EXPECT_LT(sum, 1.15 * leastSum);
    EXPECT_GE(sum, (1 - 1e-9) * leastSum);
}

}  // namespace
}  // namespace lightcook::pipeline
