// Meshes cut along the tiles of their charts (atlas/tiles.h), so that tiles can be drawn with different light maps.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "atlas/charts.h"
#include "atlas/tiles.h"
#include "formats/gltf_scene.h"

namespace lightcook::atlas {

/// A light map whose tiles go to several maps.
struct TileDivision {
    const ChartSet& charts;
    const Tiles& tiles;
    glm::ivec2 size{0};                      ///< of the light map [texels]
    const std::vector<std::uint8_t>& mapOf;  ///< [tile] number of its map
};

/// Returns, for each mesh, its triangles in the tiles of one map.
///
/// A triangle is cut only where its tiles belong to different maps, along the lines of its chart's grid. A triangle without area in the
/// light map goes where its first corner is. Cuts open no gaps: a new point on an edge becomes a vertex of every triangle with that edge,
/// in any mesh that has the same positions there, and a new point on a line becomes a vertex of all pieces of its triangle. Triangles and
/// vertices that stay keep their order.
/// meshes  as findCharts() had them
/// map     number of the map whose triangles are returned
std::vector<formats::CutMesh> cutMeshes(std::span<const formats::TriangleMesh* const> meshes, const TileDivision& division,
                                        std::uint8_t map);

}  // namespace lightcook::atlas
