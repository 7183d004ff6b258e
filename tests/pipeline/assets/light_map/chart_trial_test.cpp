#include "pipeline/assets/light_map/chart_trial.h"

#include <gmock/gmock.h>

#include <array>

namespace lightcook::pipeline {
namespace {

using testing::ElementsAre;

/// A chart whose triangles reach all quads of its box.
atlas::Chart chartAt(const glm::ivec2& first, const glm::ivec2& quads) {
    atlas::Chart chart{.first = first, .quads = quads};
    chart.reached.assign(static_cast<std::size_t>(quads.x) * static_cast<std::size_t>(quads.y), 1);
    return chart;
}

TEST(ChartTrial, TilesAreGroupedWithinTheirChartAndSmallChartsTogether) {
    // 2 x 2 tiles, of which the last two have 64 x 3 reached quads; and two charts of 10 x 10 quads.
    std::vector<atlas::Chart> charts = {chartAt({0, 0}, {64, 50}), chartAt({70, 0}, {10, 10}), chartAt({70, 20}, {10, 10})};
    std::fill(charts[0].reached.begin() + std::ptrdiff_t{64} * 35, charts[0].reached.end(), std::uint8_t{0});
    const atlas::Tiles tiles(atlas::boxesOf(charts), 32);
    ASSERT_EQ(tiles.count(), 4 + 1 + 1);
    PackedTiles packed{tiles};
    for (const atlas::Chart& chart : charts) {
        packed.firsts.push_back(chart.first);
        packed.steps.emplace_back(1);
    }
    const ChartTrial trial(charts, packed, 100, 100, 5);
    ASSERT_EQ(trial.groups().size(), 4u);
    EXPECT_THAT(trial.groups()[0].tiles, ElementsAre(0));
    EXPECT_THAT(trial.groups()[1].tiles, ElementsAre(1));
    EXPECT_THAT(trial.groups()[2].tiles, ElementsAre(2, 3)) << "96 texels each, and no chart beside it";
    EXPECT_THAT(trial.groups()[3].tiles, ElementsAre(4, 5)) << "charts of 121 texels";
    EXPECT_EQ(trial.groups()[3].texels, 2 * 11 * 11);
    EXPECT_EQ(trial.groups()[3].firstRow, 0);
    EXPECT_EQ(trial.groups()[3].rowsEnd, 31);
    std::int64_t sum = 0;
    for (const TileGroup& group : trial.groups()) sum += group.texels;
    EXPECT_EQ(sum, 65 * 36 + 2 * 11 * 11) << "each texel is of one group";
}

/// Quads of a packed chart with half the texels lie in tiles of the bake.
TEST(ChartTrial, ReducedChartsHaveTheTilesOfTheBake) {
    const std::vector<atlas::Chart> packedCharts = {chartAt({4, 4}, {40, 20})};
    const std::array bake = {atlas::ChartBox{{100, 200}, {80, 40}}};
    const atlas::Tiles tiles(bake, 32);
    ASSERT_EQ(tiles.gridOf(0), glm::ivec2(3, 1));
    const PackedTiles packed{tiles, {bake[0].first}, {glm::ivec2(2)}};
    const ChartTrial trial(packedCharts, packed, 64, 64, 5);
    ASSERT_EQ(trial.groups().size(), 1u) << "a chart of fewer texels than a group has";
    EXPECT_THAT(trial.groups()[0].tiles, ElementsAre(0, 1, 2));
}

}  // namespace
}  // namespace lightcook::pipeline
