#include "atlas/tiles.h"

#include <gtest/gtest.h>

#include <array>
#include <set>

namespace lightcook::atlas {
namespace {

constexpr std::array<ChartBox, 3> kCharts = {ChartBox{{-1, 3}, {70, 20}}, ChartBox{{100, 0}, {47, 48}}, ChartBox{{0, 200}, {1, 300}}};

TEST(Tiles, LargeChartsHaveSeveralAndNoneIsSmallerThanHalf) {
    const Tiles tiles(kCharts, 32);
    EXPECT_EQ(tiles.gridOf(0), glm::ivec2(2, 1)) << "70 quads: 32 and 38";
    EXPECT_EQ(tiles.gridOf(1), glm::ivec2(1, 2)) << "47 quads, and 32 and 16";
    EXPECT_EQ(tiles.gridOf(2), glm::ivec2(1, 9));
    EXPECT_EQ(tiles.count(), 2 + 2 + 9);
    EXPECT_EQ(tiles.line(0, 0, 1), 31 + kLineOffset);
    EXPECT_EQ(tiles.line(2, 1, 8), 456 + kLineOffset);
}

TEST(Tiles, AreNumberedChartByChartAndRowByRow) {
    const Tiles tiles(kCharts, 16);
    int next = 0;
    for (std::size_t chart = 0; chart < kCharts.size(); ++chart)
        for (int y = 0; y < tiles.gridOf(chart).y; ++y)
            for (int x = 0; x < tiles.gridOf(chart).x; ++x) EXPECT_EQ(tiles.at(chart, {x, y}), next++);
    EXPECT_EQ(tiles.count(), next);
}

TEST(Tiles, EachQuadLiesInOne) {
    const Tiles tiles(kCharts, 16);
    for (std::size_t chart = 0; chart < kCharts.size(); ++chart) {
        const ChartBox& box = kCharts[chart];
        std::set<int> found;
        for (int y = 0; y < box.quads.y; ++y)
            for (int x = 0; x < box.quads.x; ++x) {
                const glm::ivec2 quad = box.first + glm::ivec2(x, y);
                const int tile = tiles.ofQuad(chart, quad) - tiles.at(chart, {0, 0});
                const glm::ivec2 grid = tiles.gridOf(chart), place(tile % grid.x, tile / grid.x);
                for (int axis = 0; axis < 2; ++axis) {
                    EXPECT_TRUE(place[axis] == 0 || quad[axis] + kLineOffset >= tiles.line(chart, axis, place[axis]));
                    EXPECT_TRUE(place[axis] + 1 == grid[axis] || quad[axis] + kLineOffset < tiles.line(chart, axis, place[axis] + 1));
                }
                found.insert(tile);
            }
        EXPECT_EQ(static_cast<int>(found.size()), tiles.gridOf(chart).x * tiles.gridOf(chart).y);
    }
    EXPECT_EQ(tiles.ofQuad(0, {-5, 0}), 0) << "beyond the chart";
}

TEST(Tiles, WithoutASideChartsAreWhole) {
    const Tiles tiles(kCharts, 0);
    EXPECT_EQ(tiles.count(), 3);
    EXPECT_EQ(tiles.ofQuad(2, {0, 499}), 2);
}

}  // namespace
}  // namespace lightcook::atlas
