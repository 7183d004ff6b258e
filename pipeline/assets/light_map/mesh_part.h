// A part of a light map's charts as a mesh of its own.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>
#include <string>
#include <vector>

#include "atlas/charts.h"
#include "atlas/tiles.h"
#include "formats/gltf_scene.h"
#include "pipeline/scene/chart_settings.h"

namespace lightcook::pipeline {

/// Returns the charts of a light map from all meshes of a scene; see atlas::findCharts().
/// file  of the scene, for errors
/// size  of the light map [texels]
formats::Result<atlas::ChartSet> chartsOf(const formats::GltfScene& scene, const formats::Subject& file, const glm::ivec2& size);

struct MeshPart {
    formats::GltfScene scene;            ///< the triangles of the part
    atlas::ChartSet charts;              ///< of the whole mesh
    atlas::Tiles tiles;                  ///< of these charts
    std::vector<std::uint8_t> isChosen;  ///< of each tile
};

/// Cuts the triangles of a part out of a mesh. Fails with ErrorCode::Verification for tiles that the mesh does not have, and as
/// GltfScene::part() and atlas::findCharts().
/// file      of the mesh, for errors
/// size      of the light map [texels]
/// hasLines  lines and points of the mesh, too
formats::Result<MeshPart> partOf(const formats::GltfScene& scene, const formats::Subject& file, const ChartPart& part,
                                 const glm::ivec2& size, bool hasLines);

}  // namespace lightcook::pipeline
