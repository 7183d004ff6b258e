// Views of a mesh around a texel of its light map, lit by the bake and by the cooked map. A mesh may have several light maps.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "pipeline/assets/light_map/cooked_light_map.h"
#include "pipeline/assets/light_map/mesh_view.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/assets/results.h"

namespace lightcook::pipeline {

/// A light map as it was baked and as it was cooked.
struct ComparedMap {
    std::string name;
    LightMapSource& bake;
    const CookedLightMapReader& cooked;
};

/// A texel of one of several light maps.
struct MapTexel {
    std::size_t map = 0;  ///< number of the light map
    glm::ivec2 texel{0};
};

/// Draws the mesh as a camera in front of a texel sees it, and writes both pictures into the action's folder. A pixel shows the exit
/// radiance of a white surface with the map's own normal, as the verifier measures it: the bake filtered between covered texels alone, the
/// cooked map decoded from filtered texels. Empty if the mesh does not have the texel.
/// triangles  of the mesh, with the numbers of their maps
/// maps       at least one
/// key        log-average luminance that is shown as middle grey
/// name       of the files, before their endings
formats::Result<std::optional<RenderedView>> writeRenderedView(std::span<const verify::SurfaceTriangle> triangles, const MapTexel& texel,
                                                               std::span<const ComparedMap> maps, double key, const ActionContext& context,
                                                               const std::string& name);

}  // namespace lightcook::pipeline
