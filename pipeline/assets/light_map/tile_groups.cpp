#include "pipeline/assets/light_map/tile_groups.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace lightcook::pipeline {
namespace {

using atlas::Chart;
using verify::PlaceGroups;

/// Calls visit(x, y, quad) for each texel of the map that a filter inside a quad of the chart reads, with the quad's place in the chart.
/// Texels come up to four times.
template <class Visit>
void forEachRead(const Chart& chart, const glm::ivec2& size, Visit visit) {
    for (int y = 0; y < chart.quads.y; ++y)
        for (int x = 0; x < chart.quads.x; ++x)
            for (int corner = 0; chart.reaches(x, y) && corner < 4; ++corner) {
                const glm::ivec2 at = chart.first + glm::ivec2(x + corner % 2, y + corner / 2);
                if (at.x >= 0 && at.y >= 0 && at.x < size.x && at.y < size.y) visit(at.x, at.y, glm::ivec2(x, y));
            }
}

/// The texels of a tile.
struct TileTexels {
    std::int64_t count = 0;
    int firstRow = std::numeric_limits<int>::max();
};

/// Sets the tile of each texel that triangles read, and returns what each tile reads.
std::vector<TileTexels> readTiles(const std::vector<Chart>& charts, const PackedTiles& packed, formats::Image<std::uint32_t>& tileOf) {
    const glm::ivec2 size(tileOf.width(), tileOf.height());
    for (std::size_t i = 0; i < charts.size(); ++i)
        forEachRead(charts[i], size, [&](int x, int y, const glm::ivec2& quad) {
            tileOf.at(x, y) = static_cast<std::uint32_t>(packed.tiles.ofQuad(i, packed.firsts[i] + quad * packed.steps[i]));
        });
    std::vector<TileTexels> tiles(static_cast<std::size_t>(packed.tiles.count()));
    for (int y = 0; y < size.y; ++y)
        for (int x = 0; x < size.x; ++x) {
            if (tileOf.at(x, y) == PlaceGroups::kNone) continue;
            TileTexels& texels = tiles[tileOf.at(x, y)];
            ++texels.count;
            texels.firstRow = std::min(texels.firstRow, y);
        }
    return tiles;
}

/// Joins tiles to groups.
class TileGrouping {
public:
    explicit TileGrouping(const std::vector<TileTexels>& tiles) : tiles_(tiles), groupOfTile_(tiles.size(), PlaceGroups::kNone) {}

    /// Adds a tile to a group that is not finished, unless the tile has no texels.
    void addTo(TileGroup& group, int tile) const {
        const TileTexels& texels = tiles_[static_cast<std::size_t>(tile)];
        if (texels.count == 0) return;
        group.firstRow = group.tiles.empty() ? texels.firstRow : std::min(group.firstRow, texels.firstRow);
        group.texels += texels.count;
        group.tiles.push_back(tile);
    }
    /// Groups the tiles [first, end) of a large chart: large tiles alone, the others with those that follow.
    void groupTilesOfChart(int first, int end) {
        TileGroup smallTiles;
        for (int tile = first; tile < end; ++tile) {
            TileGroup alone;
            addTo(alone, tile);
            if (alone.texels >= kLeastGroupTexelsOfTiles)
                finish(alone);
            else
                addTo(smallTiles, tile);
            if (smallTiles.texels >= kLeastGroupTexelsOfTiles) finish(smallTiles);
        }
        finish(smallTiles);
    }
    /// Groups whole charts, from the top of the map down.
    void joinCharts(std::vector<TileGroup> charts) {
        std::ranges::stable_sort(charts, {}, &TileGroup::firstRow);
        TileGroup together;
        for (const TileGroup& chart : charts) {
            for (const int tile : chart.tiles) addTo(together, tile);
            if (together.texels >= kLeastGroupTexels) finish(together);
        }
        finish(together);
    }
    std::uint32_t groupOf(std::uint32_t tile) const { return groupOfTile_[tile]; }
    std::vector<TileGroup> groups() && { return std::move(groups_); }

private:
    /// Takes a group unless it is empty, and leaves an empty one.
    void finish(TileGroup& group) {
        if (group.tiles.empty()) return;
        std::ranges::sort(group.tiles);
        for (const int tile : group.tiles) groupOfTile_[static_cast<std::size_t>(tile)] = static_cast<std::uint32_t>(groups_.size());
        groups_.push_back(std::exchange(group, {}));
    }

    const std::vector<TileTexels>& tiles_;
    std::vector<std::uint32_t> groupOfTile_;
    std::vector<TileGroup> groups_;
};

}  // namespace

PlaceGroups TileGroups::places(std::optional<double> maxVisible) const {
    PlaceGroups places{ofTexel.view(), groups.size()};
    if (maxVisible) places.maxVisible = static_cast<float>(*maxVisible);
    return places;
}

TileGroups groupTiles(const std::vector<Chart>& charts, const PackedTiles& packed, int width, int height) {
    TileGroups made{{}, formats::Image<std::uint32_t>(width, height, PlaceGroups::kNone)};
    const std::vector<TileTexels> tiles = readTiles(charts, packed, made.ofTexel);  // which has tiles until they are grouped
    TileGrouping grouping(tiles);
    std::vector<TileGroup> small;  // whole charts
    for (std::size_t i = 0; i < charts.size(); ++i) {
        const glm::ivec2 grid = packed.tiles.gridOf(i);
        const int first = packed.tiles.at(i, {0, 0}), end = first + grid.x * grid.y;
        TileGroup whole;
        for (int tile = first; tile < end; ++tile) grouping.addTo(whole, tile);
        if (whole.texels < kLeastGroupTexels)
            small.push_back(std::move(whole));
        else
            grouping.groupTilesOfChart(first, end);
    }
    grouping.joinCharts(std::move(small));
    for (std::uint32_t& texel : made.ofTexel.texels())
        if (texel != PlaceGroups::kNone) texel = grouping.groupOf(texel);
    made.groups = std::move(grouping).groups();
    return made;
}

}  // namespace lightcook::pipeline
