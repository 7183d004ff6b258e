// Views of a mesh around a texel of its light map, lit by the bake and by the cooked map.
#pragma once

#include <optional>
#include <string>

#include "pipeline/assets/light_map/cooked_light_map.h"
#include "pipeline/assets/light_map/mesh_view.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/assets/results.h"

namespace lightcook::pipeline {

/// Draws the mesh as a camera in front of a texel sees it, and writes both pictures into the action's folder. A pixel shows the exit
/// radiance of a white surface with the map's own normal, as the verifier measures it: the bake filtered between covered texels alone, the
/// cooked map decoded from filtered texels. Empty if the mesh does not have the texel.
/// triangles  of the mesh
/// key        log-average luminance that is shown as middle grey
/// name       of the files, before their endings
formats::Result<std::optional<RenderedView>> writeRenderedView(std::span<const verify::SurfaceTriangle> triangles, const glm::ivec2& texel,
                                                               LightMapSource& bake, const CookedLightMapReader& cooked, double key,
                                                               const ActionContext& context, const std::string& name);

}  // namespace lightcook::pipeline
