// A cooked light map whose charts were packed, read at places of the bake that it was made of.
#pragma once

#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "lighting/sh.h"
#include "pipeline/assets/light_map/chart_places.h"
#include "pipeline/assets/light_map/cooked_light_map.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// Places of a bake that are decoded at once: their coefficients are in memory together.
inline constexpr int kPlacesAtOnce = 1 << 20;

/// A cooked map, and where charts of its bake lie in it.
struct PackedReading {
    const ChartPlaces& charts;
    const CookedLightMapReader& cooked;
    /// The repacked bake: at rims of learned layouts the decode is that of its nearest covered texel. Null: that of the nearest texel.
    LightMapSource* repacked = nullptr;
    double key = 0;  ///< that the cooked map was opened with
};

/// Returns the coefficients that the shader decodes at places of the bake, from filtered texels; zero where no triangle comes near.
/// places  [texels] of the bake; integers are texel centres
formats::Result<std::vector<lighting::ShRgb>> decodedAt(std::span<const glm::dvec2> places, const PackedReading& reading,
                                                        const ActionContext& context);

}  // namespace lightcook::pipeline
