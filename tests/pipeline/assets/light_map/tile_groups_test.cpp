#include "pipeline/assets/light_map/tile_groups.h"

#include <gmock/gmock.h>

#include <array>
#include <limits>

namespace lightcook::pipeline {
namespace {

using testing::ElementsAre;

/// A chart whose triangles reach all quads of its box.
atlas::Chart chartAt(const glm::ivec2& first, const glm::ivec2& quads) {
    atlas::Chart chart{.first = first, .quads = quads};
    chart.reached.assign(static_cast<std::size_t>(quads.x) * static_cast<std::size_t>(quads.y), 1);
    return chart;
}

TEST(TileGroups, TilesAreGroupedWithinTheirChartAndSmallChartsTogether) {
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
    const auto [groups, ofTexel] = groupTiles(charts, packed, 100, 100);
    ASSERT_EQ(groups.size(), 4u);
    EXPECT_THAT(groups[0].tiles, ElementsAre(0));
    EXPECT_THAT(groups[1].tiles, ElementsAre(1));
    EXPECT_THAT(groups[2].tiles, ElementsAre(2, 3)) << "96 texels each, and no chart beside it";
    EXPECT_THAT(groups[3].tiles, ElementsAre(4, 5)) << "charts of 121 texels";
    EXPECT_EQ(groups[3].texels, 2 * 11 * 11);
    std::int64_t sum = 0;
    for (const TileGroup& group : groups) sum += group.texels;
    EXPECT_EQ(sum, 65 * 36 + 2 * 11 * 11) << "each texel is of one group";

    std::vector<std::int64_t> texels(groups.size());
    for (const std::uint32_t group : ofTexel.texels())
        if (group != verify::PlaceGroups::kNone) ++texels[group];
    for (std::size_t i = 0; i < groups.size(); ++i) EXPECT_EQ(texels[i], groups[i].texels) << i;
    EXPECT_EQ(ofTexel.at(31, 31), 0u);
    EXPECT_EQ(ofTexel.at(32, 31), 1u) << "the texel of a line is of the tile behind it";
    EXPECT_EQ(ofTexel.at(31, 32), 2u);
    EXPECT_EQ(ofTexel.at(70, 25), 3u);
    EXPECT_EQ(ofTexel.at(66, 0), verify::PlaceGroups::kNone) << "between charts";
}

TEST(TileGroups, ArePlacesOfATrialWithItsLimit) {
    const std::vector<atlas::Chart> charts = {chartAt({0, 0}, {40, 40})};
    const atlas::Tiles tiles(atlas::boxesOf(charts), 32);
    const TileGroups grouped = groupTiles(charts, {tiles, {{0, 0}}, {glm::ivec2(1)}}, 48, 48);
    const verify::PlaceGroups places = grouped.places(5);
    EXPECT_EQ(places.count, grouped.groups.size());
    EXPECT_EQ(places.maxVisible, 5);
    EXPECT_EQ(places.at(40, 40), 0u);
    EXPECT_EQ(places.at(41, 40), verify::PlaceGroups::kNone);
    EXPECT_EQ(grouped.places({}).maxVisible, std::numeric_limits<float>::max());
}

/// Quads of a packed chart with half the texels lie in tiles of the bake.
TEST(TileGroups, ReducedChartsHaveTheTilesOfTheBake) {
    const std::vector<atlas::Chart> packedCharts = {chartAt({4, 4}, {40, 20})};
    const std::array bake = {atlas::ChartBox{{100, 200}, {80, 40}}};
    const atlas::Tiles tiles(bake, 32);
    ASSERT_EQ(tiles.gridOf(0), glm::ivec2(3, 1));
    const PackedTiles packed{tiles, {bake[0].first}, {glm::ivec2(2)}};
    const std::vector<TileGroup> groups = groupTiles(packedCharts, packed, 64, 64).groups;
    ASSERT_EQ(groups.size(), 1u) << "a chart of fewer texels than a group has";
    EXPECT_THAT(groups[0].tiles, ElementsAre(0, 1, 2));
}

}  // namespace
}  // namespace lightcook::pipeline
