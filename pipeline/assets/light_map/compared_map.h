// Cooked light maps beside their bakes, on the surface that they light.
#pragma once

#include <span>
#include <string>

#include "pipeline/assets/light_map/cooked_light_map.h"
#include "pipeline/assets/light_map/source.h"
#include "verify/seams.h"
#include "verify/visible.h"

namespace lightcook::pipeline {

struct ComparedMap {
    std::string name;
    LightMapSource& bake;
    const CookedLightMapReader& cooked;
};

/// A surface and its light maps: one, or all that a light map was split into.
struct LitSurface {
    std::span<const ComparedMap> maps;                   ///< at least one; all cooked maps are read with the same key and viewing
    std::span<const verify::SurfaceTriangle> triangles;  ///< with the numbers of their maps; empty: no mesh that can be read has UVs
    verify::Viewing viewing;
};

}  // namespace lightcook::pipeline
