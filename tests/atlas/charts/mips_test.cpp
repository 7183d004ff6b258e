// Mip levels that keep charts apart, against the texels that a bilinear filter reads at many places of each chart.
#include "atlas/mips.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>
#include <set>

namespace lightcook::atlas {
namespace {

using formats::Image;

/// A map with charts of the test's own, numbered from 1.
struct MipMap {
    Image<std::uint8_t> chart;
    MipMap(int width, int height) : chart(width, height, 0) {}
    void add(std::uint8_t number, glm::ivec2 first, glm::ivec2 size) {
        for (int y = first.y; y < first.y + size.y; ++y)
            for (int x = first.x; x < first.x + size.x; ++x) chart.at(x, y) = number;
    }
    /// isNumbered  the bake has the numbers of its charts
    std::vector<CoveredRun> runs(bool isNumbered = false) const {
        std::vector<CoveredRun> runs;
        for (int y = 0; y < chart.height(); y += 3) {  // in strips, as they are read
            const int count = std::min(3, chart.height() - y);
            formats::LightMapStrip strip;
            strip.firstRow = y;
            strip.covered = Image<std::uint8_t>(chart.width(), count);
            if (isNumbered) strip.chart = Image<std::uint32_t>(chart.width(), count);
            for (int row = 0; row < count; ++row)
                for (int x = 0; x < chart.width(); ++x) {
                    strip.covered.at(x, row) = chart.at(x, y + row);
                    if (isNumbered) strip.chart.at(x, row) = chart.at(x, y + row) != 0 ? chart.at(x, y + row) : formats::kNoChart;
                }
            const auto rows = coveredRuns(strip);
            runs.insert(runs.end(), rows.begin(), rows.end());
        }
        if (!isNumbered) findMipCharts(runs);
        return runs;
    }
    MipLevels levels(bool isNumbered = false) const { return safeMipLevels(runs(isNumbered), chart.width(), chart.height()); }

    /// Returns the texels of a level that have a weight at a place, in texels of level 0 from the map's corner.
    std::vector<glm::ivec2> readAt(const glm::dvec2& place, int level) const {
        const double side = 1 << level;
        const auto along = [&](double at, int count) {
            const double u = at / side - 0.5, below = std::floor(u);
            std::set<int> texels = {std::clamp(static_cast<int>(below), 0, count - 1)};
            if (u > below) texels.insert(std::clamp(static_cast<int>(below) + 1, 0, count - 1));
            return texels;
        };
        std::vector<glm::ivec2> texels;
        for (const int y : along(place.y, chart.height() >> level))
            for (const int x : along(place.x, chart.width() >> level)) texels.emplace_back(x, y);
        return texels;
    }
    bool holdsOther(const glm::ivec2& texel, int level, std::uint8_t own) const {
        const int side = 1 << level;
        for (int y = texel.y * side; y < (texel.y + 1) * side; ++y)
            for (int x = texel.x * side; x < (texel.x + 1) * side; ++x)
                if (chart.at(x, y) != 0 && chart.at(x, y) != own) return true;
        return false;
    }
    /// Tries places of each texel, its corners and edges among them.
    bool isSafe(int level) const {
        for (int y = 0; y < chart.height(); ++y)
            for (int x = 0; x < chart.width(); ++x) {
                if (chart.at(x, y) == 0) continue;
                for (int j = 0; j <= 4; ++j)
                    for (int i = 0; i <= 4; ++i)
                        for (const glm::ivec2& texel : readAt({x + i / 4.0, y + j / 4.0}, level))
                            if (holdsOther(texel, level, chart.at(x, y))) return false;
            }
        return true;
    }
};

TEST(MipLevels, ChartsSomeTexelsApartEndThem) {
    // Texels between two charts, the column at which the first one ends, and the levels.
    const std::vector<std::array<int, 3>> cases = {{1, 16, 1}, {2, 16, 2}, {2, 15, 2},  {4, 16, 3}, {4, 15, 2},
                                                   {5, 15, 3}, {5, 18, 3}, {11, 17, 4}, {11, 23, 4}};
    for (const auto& [gap, end, expected] : cases) {
        MipMap map(64, 64);
        map.add(1, {0, 0}, {end, 64});
        map.add(2, {end + gap, 0}, {64 - end - gap, 64});
        EXPECT_EQ(map.levels().count, expected) << gap << " texels apart, from column " << end;
        EXPECT_EQ(map.levels().end, MipLevels::End::Charts);
        EXPECT_FALSE(map.isSafe(expected));
        for (int level = 1; level < expected; ++level) EXPECT_TRUE(map.isSafe(level)) << gap << ", level " << level;
    }
}

TEST(MipLevels, AreTheSafeOnesOfRandomCharts) {
    std::mt19937 random(5);
    const auto between = [&](int low, int high) { return std::uniform_int_distribution(low, high)(random); };
    std::map<int, int> counts;
    for (int trial = 0; trial < 60; ++trial) {
        MipMap map(64, 64);
        const int top = between(0, 4), middle = between(6, 14);
        map.add(1, {between(0, 5), top}, {between(6, 14), middle});
        map.add(2, {20 + between(1, 24), top + between(0, 3)}, {between(3, 15), between(3, 9)});
        map.add(3, {between(0, 10), top + middle + between(1, 24)}, {between(3, 10), between(1, 3)});
        const MipLevels levels = map.levels();
        ++counts[levels.count];
        for (int level = 1; level < levels.count; ++level) EXPECT_TRUE(map.isSafe(level)) << "trial " << trial << ", level " << level;
        if (levels.end == MipLevels::End::Charts) {
            EXPECT_FALSE(map.isSafe(levels.count)) << "trial " << trial;
        }
    }
    EXPECT_GE(counts.size(), 3u) << "the charts are of several kinds";
}

TEST(MipLevels, TexelsThatTouchAreOneChartAlsoByACorner) {
    MipMap map(32, 32);
    map.add(1, {0, 0}, {9, 9});
    map.add(1, {9, 9}, {6, 6});  // by a corner
    map.add(1, {3, 9}, {1, 20});
    map.add(1, {4, 28}, {20, 1});
    map.add(1, {23, 1}, {1, 27});  // a ring that closes below
    const auto runs = map.runs();
    for (const CoveredRun& run : runs) EXPECT_EQ(run.chart, runs.front().chart) << run.row;
    EXPECT_EQ(map.levels().count, 4);
    EXPECT_EQ(map.levels().end, MipLevels::End::Size) << "32, 16, 8, 4";
}

TEST(MipLevels, ChartsThatTheBakeNumbersMayTouch) {
    MipMap map(32, 32);
    map.add(1, {0, 0}, {16, 32});
    map.add(2, {16, 0}, {16, 32});
    EXPECT_EQ(map.levels().count, 4) << "one chart, since nothing tells them apart";
    const MipLevels numbered = map.levels(true);
    EXPECT_EQ(numbered.count, 1);
    EXPECT_EQ(numbered.end, MipLevels::End::Charts);
    for (const CoveredRun& run : map.runs(true)) EXPECT_EQ(run.chart, run.begin < 16 ? 1u : 2u);
}

TEST(MipLevels, HaveSidesOfWholeBlocks) {
    const auto levels = [](int width, int height) {
        MipMap map(width, height);
        map.add(1, {0, 0}, {width, height});
        return map.levels().count;
    };
    EXPECT_EQ(levels(64, 16), 3);
    EXPECT_EQ(levels(24, 24), 2);
    EXPECT_EQ(levels(12, 72), 1);
    EXPECT_EQ(levels(7, 64), 1);
    EXPECT_EQ(levels(4, 4), 1);
}

}  // namespace
}  // namespace lightcook::atlas
