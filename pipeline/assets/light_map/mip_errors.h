// Verification of the mip levels of a cooked light map. Each level from 1 on is decoded from the file and held against the bake's mean over
// its texels, at texel centres and at places between them, with the certified bounds of level 0. All limits on the error hold for each
// level. Places between the texels of two charts count nowhere: no surface lies there (atlas/mips.h). So do the limits on sampled errors
// between two levels, where a trilinear sampler mixes the texels of both.
#pragma once

#include <filesystem>
#include <vector>

#include "pipeline/assets/cooked_asset.h"
#include "pipeline/assets/light_map/block_errors.h"
#include "pipeline/assets/light_map/cooked_light_map.h"
#include "pipeline/assets/light_map/light_map.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/graph/action.h"
#include "verify/figures.h"
#include "verify/violation.h"
#include "verify/visible.h"

namespace lightcook::pipeline {

/// A cooked light map whose levels are verified.
struct MippedLightMap {
    const std::filesystem::path& folder;
    const CookedAsset& asset;
    LightMapSource& bake;
    const LightMapVerifyParameters& parameters;
    double key = 0;  ///< of level 0, as is the display
    verify::Viewing viewing;
};

/// Errors of each level from 1 on, "mip 1" and on, and between each and the larger one before it, "mip 0 to 1" and on.
struct MipErrors {
    std::vector<verify::StageError> levels, blends;
};

/// Returns the errors of the levels of a map, and adds their violations. Fails if the textures have levels that mix charts.
/// level0  the map itself
formats::Result<MipErrors> mipErrors(const MippedLightMap& map, const CookedLightMapReader& level0,
                                     std::vector<verify::Violation>& violations, const ActionContext& context);

}  // namespace lightcook::pipeline
