// Seams of light maps: steps of light between both sides of the edges that two charts share, in the bake and cooked. The charts may lie in
// different maps of a split light map.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "pipeline/assets/light_map/cooked_light_map.h"
#include "pipeline/assets/light_map/rendered_view.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/assets/results.h"
#include "pipeline/graph/action.h"
#include "verify/seams.h"

namespace lightcook::pipeline {

/// Measures the seams of a map. Places are lit strip by strip, in batches of a bounded size, so that a map or mesh of any size takes the
/// memory of one batch. The result is the same on any number of threads.
/// hasMesh    false: the map has no mesh, or one that cannot be read
/// triangles  of the mesh
formats::Result<SeamFigures> measureSeams(bool hasMesh, std::span<const verify::SurfaceTriangle> triangles, LightMapSource& bake,
                                          const CookedLightMapReader& cooked, const ActionContext& context);

/// Measures the seams between light maps: the edges whose sides lie in different ones. There is one stage, "total": the maps may have
/// stages of their own. The result is the same on any number of threads.
/// maps       all cooked with the same key and viewing
/// triangles  of the meshes of all maps, with the numbers of their maps
formats::Result<SeamFigures> measureSeamsBetween(std::span<const ComparedMap> maps, std::span<const verify::SurfaceTriangle> triangles,
                                                 const ActionContext& context);

/// Draws the worst seams as a camera in front of each sees them, in the order of SeamFigures::worst. Steps below half of a just noticeable
/// difference get no picture.
/// triangles  of the mesh, with the numbers of their maps
/// name       of the files, before their numbers
formats::Result<std::vector<RenderedView>> writeSeamViews(const SeamFigures& seams, std::span<const verify::SurfaceTriangle> triangles,
                                                          std::span<const ComparedMap> maps, const verify::Viewing& viewing,
                                                          const ActionContext& context, const std::string& name);

}  // namespace lightcook::pipeline
