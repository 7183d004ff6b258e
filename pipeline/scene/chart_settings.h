// Keys `charts` and `charts_max_visible` of [output] and [[light_map]].
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/scene/chart_mode.h"

namespace lightcook::pipeline {

/// Largest value of charts_max_visible.
inline constexpr double kMostChartsVisible = 100;

/// Settings of one place: [output] or a [[light_map]]. What is absent in a light map is that of the output.
struct ChartSettings {
    std::optional<ChartMode> mode;
    std::optional<double> maxVisible;  ///< visible error that fewer texels may add; 0: charts are moved only
};

/// Most maps that a cook splits a light map into.
inline constexpr std::size_t kMostMaps = 3;

/// Returns the names that the maps of a split may have, that of the coarsest first.
inline std::array<std::string, kMostMaps> splitNamesOf(const std::string& lightMap) {
    return {lightMap, lightMap + "_fine", lightMap + "_finest"};
}

/// The tiles of one of the maps that a cook splits a light map into (pipeline/assets/light_map/chart_split.h).
struct ChartPart {
    std::string of;          ///< light map of the scene file; the part of this name has the lines and points of the mesh, too
    int tileSide = 0;        ///< of the tiles that charts are cut into (atlas/tiles.h) [texels]; 0: charts are whole
    std::vector<int> tiles;  ///< numbers of the tiles, ascending
    /// Tiles of one of the other two maps, if there are three: triangles are cut at the borders between those too, so that no gaps open.
    std::vector<int> otherTiles = {};
    bool operator==(const ChartPart&) const = default;
};

}  // namespace lightcook::pipeline
