// Groups of tiles of a light map that are large enough to be judged, and given a layout, apart from each other.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <optional>
#include <vector>

#include "atlas/charts.h"
#include "atlas/tiles.h"
#include "formats/image.h"
#include "verify/light_map.h"

namespace lightcook::pipeline {

/// Maps quads of a packed map to tiles of the bake that it was packed from.
struct PackedTiles {
    const atlas::Tiles& tiles;
    std::vector<glm::ivec2> firsts = {};  ///< quad of the bake at which the first packed quad of each chart begins
    std::vector<glm::ivec2> steps = {};   ///< texels of the bake for each texel of the packed chart, on each axis
};

/// Tiles that get one layout: a large one, or small ones that lie near each other.
struct TileGroup {
    std::vector<int> tiles;   ///< ascending
    std::int64_t texels = 0;  ///< that filters read
    int firstRow = 0;         ///< of these texels
};

struct TileGroups {
    std::vector<TileGroup> groups;
    formats::Image<std::uint32_t> ofTexel;  ///< see verify::PlaceGroups

    /// Returns the groups as a trial takes them; they must not outlive this object.
    /// maxVisible  limit that samples of visible errors are counted above; empty: none is counted
    verify::PlaceGroups places(std::optional<double> maxVisible) const;
};

/// Charts with fewer texels form groups of at least this many.
inline constexpr std::int64_t kLeastGroupTexels = 1024;
/// Small tiles of a larger chart form groups of at least this many texels. The last group of a chart may have fewer.
inline constexpr std::int64_t kLeastGroupTexelsOfTiles = 256;

/// Groups the tiles of a map of width x height texels.
/// charts  of the light map's mesh
TileGroups groupTiles(const std::vector<atlas::Chart>& charts, const PackedTiles& packed, int width, int height);

}  // namespace lightcook::pipeline
