#include "pipeline/cook/split_maps.h"

#include <gmock/gmock.h>

#include "tests/pipeline/scene_with_one_map.h"

namespace lightcook::pipeline {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// A split of tiles 0 to 5 into maps of the given tiles.
TriedSplit splitOf(std::vector<std::vector<int>> tiles, int tileSide) {
    TriedSplit split;
    split.tileSide = tileSide;
    for (std::vector<int>& each : tiles) split.maps.push_back({"ratio", std::move(each), 0.5});
    return split;
}

LightMapEntry room() {
    LightMapEntry entry = sceneWithOneMap().lightMaps.front();
    entry.name = "room";
    return entry;
}

TEST(PartsOf, NamesTheMapsFromTheCoarsestOn) {
    const auto parts = partsOf(room(), splitOf({{0, 1, 2}, {3, 4}, {5}}, 32), 0);
    ASSERT_EQ(parts.size(), 3u);
    EXPECT_EQ(parts[0].name, "room");
    EXPECT_EQ(parts[1].name, "room_fine");
    EXPECT_EQ(parts[2].name, "room_finest");
    for (const LightMapEntry& part : parts) {
        EXPECT_EQ(part.part->of, "room");
        EXPECT_EQ(part.nameInScene(), "room");
        EXPECT_EQ(part.charts.mode, ChartMode::Pack);
    }
}

/// Each part cuts its triangles where tiles of the two other maps meet, too.
TEST(PartsOf, APartOfThreeKnowsTheTilesOfAnotherOne) {
    const auto parts = partsOf(room(), splitOf({{0, 1, 2}, {3, 4}, {5}}, 32), 0);
    ASSERT_EQ(parts.size(), 3u);
    EXPECT_THAT(parts[0].part->tiles, ElementsAre(0, 1, 2));
    EXPECT_THAT(parts[0].part->otherTiles, ElementsAre(5));
    EXPECT_THAT(parts[1].part->tiles, ElementsAre(3, 4));
    EXPECT_THAT(parts[1].part->otherTiles, ElementsAre(5));
    EXPECT_THAT(parts[2].part->tiles, ElementsAre(5));
    EXPECT_THAT(parts[2].part->otherTiles, ElementsAre(3, 4));
}

TEST(PartsOf, TwoMapsOrWholeChartsNeedNoOtherTiles) {
    for (const LightMapEntry& part : partsOf(room(), splitOf({{0, 1, 2}, {3, 4, 5}}, 32), 0)) EXPECT_THAT(part.part->otherTiles, IsEmpty());
    for (const LightMapEntry& part : partsOf(room(), splitOf({{0}, {1}, {2}}, 0), 0)) EXPECT_THAT(part.part->otherTiles, IsEmpty());
}

}  // namespace
}  // namespace lightcook::pipeline
