// Meshes cut along the tiles of their charts (atlas/tiles.h), so that some tiles can be drawn with another light map than the rest.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "atlas/charts.h"
#include "atlas/tiles.h"
#include "formats/gltf_scene.h"

namespace lightcook::atlas {

/// Returns the triangles of some tiles, in place of those of each mesh.
///
/// A triangle is cut only where its tiles are chosen differently, along the lines of its chart's grid; one without area in the light map
/// goes where its first corner is. No gap opens between what is chosen and what is not: a point on an edge is a vertex of all triangles
/// with that edge, in any mesh that has the same positions there, and a point on a line is a vertex of all pieces of a triangle. What is
/// left of a mesh keeps its order.
/// meshes    as findCharts() had them
/// size      of the light map [texels]
/// isChosen  of each tile
std::vector<formats::CutMesh> cutMeshes(std::span<const formats::TriangleMesh* const> meshes, const ChartSet& charts, const Tiles& tiles,
                                        const glm::ivec2& size, const std::vector<std::uint8_t>& isChosen);

}  // namespace lightcook::atlas
