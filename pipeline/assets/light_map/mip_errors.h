// Verification of the mip levels of a cooked light map. Each level from 1 on is decoded from the file and held against the bake's mean over
// its texels, at texel centres and at places between them, with the certified bounds of level 0. All limits on the error hold for each
// level. Places between the texels of two charts count nowhere: no surface lies there (atlas/mips.h).
#pragma once

#include <filesystem>
#include <vector>

#include "pipeline/assets/light_map/light_map.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/graph/action.h"
#include "pipeline/manifest/cooked_asset.h"
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
    double maxError = 0;
    double key = 0;  ///< of level 0, as is the display
    verify::Viewing viewing;
};

/// Returns the errors of each level from 1 on, named "mip 1" and on, and adds a violation for each limit that a level is over. Fails if the
/// textures have levels that mix charts.
formats::Result<std::vector<verify::StageError>> mipErrors(const MippedLightMap& map, std::vector<verify::Violation>& violations,
                                                           const ActionContext& context);

}  // namespace lightcook::pipeline
