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

}  // namespace

PlaceGroups TileGroups::places(std::optional<double> maxVisible) const {
    PlaceGroups places{ofTexel.view(), groups.size()};
    if (maxVisible) places.maxVisible = static_cast<float>(*maxVisible);
    return places;
}

TileGroups groupTiles(const std::vector<Chart>& charts, const PackedTiles& packed, int width, int height) {
    TileGroups made{{}, formats::Image<std::uint32_t>(width, height, PlaceGroups::kNone)};
    const std::vector<TileTexels> tiles = readTiles(charts, packed, made.ofTexel);  // which has tiles until they are grouped
    std::vector<std::uint32_t> groupOfTile(tiles.size(), PlaceGroups::kNone);
    const auto addTo = [&](TileGroup& group, int tile) {
        const TileTexels& texels = tiles[static_cast<std::size_t>(tile)];
        if (texels.count == 0) return;
        group.firstRow = group.tiles.empty() ? texels.firstRow : std::min(group.firstRow, texels.firstRow);
        group.texels += texels.count;
        group.tiles.push_back(tile);
    };
    const auto finish = [&](TileGroup& group) {
        if (group.tiles.empty()) return;
        std::ranges::sort(group.tiles);
        for (const int tile : group.tiles) groupOfTile[static_cast<std::size_t>(tile)] = static_cast<std::uint32_t>(made.groups.size());
        made.groups.push_back(std::exchange(group, {}));
    };
    std::vector<TileGroup> small;  // whole charts
    for (std::size_t i = 0; i < charts.size(); ++i) {
        const glm::ivec2 grid = packed.tiles.gridOf(i);
        const int first = packed.tiles.at(i, {0, 0}), end = first + grid.x * grid.y;
        TileGroup whole;
        for (int tile = first; tile < end; ++tile) addTo(whole, tile);
        if (whole.texels < kLeastGroupTexels) {
            small.push_back(std::move(whole));
            continue;
        }
        TileGroup littleTiles;
        for (int tile = first; tile < end; ++tile) {
            TileGroup alone;
            addTo(alone, tile);
            if (alone.texels >= kLeastGroupTexelsOfTiles)
                finish(alone);
            else
                addTo(littleTiles, tile);
            if (littleTiles.texels >= kLeastGroupTexelsOfTiles) finish(littleTiles);
        }
        finish(littleTiles);
    }
    std::ranges::stable_sort(small, {}, &TileGroup::firstRow);
    TileGroup together;
    for (const TileGroup& chart : small) {
        for (const int tile : chart.tiles) addTo(together, tile);
        if (together.texels >= kLeastGroupTexels) finish(together);
    }
    finish(together);
    for (std::uint32_t& texel : made.ofTexel.texels())
        if (texel != PlaceGroups::kNone) texel = groupOfTile[texel];
    return made;
}

}  // namespace lightcook::pipeline
