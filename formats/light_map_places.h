// Nodes of a mesh at their places in a light map, as a scene file states them ([[light_map.place]]). Bakers that give each object a
// rectangle of a shared map (Unity's lightmapScaleOffset, bevy's uv_rect) or a map of its own have them.
#pragma once

#include <array>
#include <string>
#include <vector>

namespace lightcook::formats {

/// A node, and all nodes below it that have no place of their own. Their light-map UVs in the map are uv * scale + offset, V down.
struct NodePlace {
    std::string node;  ///< its name, or the end of its path: "Room/Wall"
    std::array<double, 2> scale = {1, 1}, offset = {0, 0};
};

/// Largest magnitude of a scale or an offset.
inline constexpr double kMostPlace = 1e4;

}  // namespace lightcook::formats
