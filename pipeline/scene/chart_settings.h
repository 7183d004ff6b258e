// Keys `charts` and `charts_max_visible` of [output] and [[light_map]].
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "pipeline/scene/chart_mode.h"

namespace lightcook::pipeline {

/// Largest value of charts_max_visible.
inline constexpr double kMostChartsVisible = 100;

/// Settings of one place: [output], a [[light_map]], or the command line. What is absent is that of the place before.
struct ChartSettings {
    std::optional<ChartMode> mode;
    std::optional<double> maxVisible;  ///< visible error that fewer texels may add; 0: charts are moved only
};

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
