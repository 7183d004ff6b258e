// Errors of a cooked light map whose charts were packed, against the bake as it was before.
#pragma once

#include <cstdint>

#include "pipeline/assets/light_map/cooked_light_map.h"
#include "pipeline/assets/light_map/light_map.h"
#include "pipeline/assets/light_map/unpacked_bake.h"
#include "pipeline/graph/action.h"
#include "verify/figures.h"

namespace lightcook::pipeline {

/// Stage of a repacked map with the figures against the repacked bake; "total" is against the bake.
inline constexpr const char* kRepackedStage = "repacked";

struct UnpackedErrors {
    verify::StageError total;       ///< at places on the surface, with those of texel centres beside them; without bounds
    std::int64_t unreadTexels = 0;  ///< covered texels of the bake that no triangle reads: they are not judged
};

/// Opens the bake as it was.
formats::Result<LightMapSource*> openUnpacked(const UnpackedBake& unpacked, const ActionContext& context);

/// A bake with the one that its charts were packed into.
struct BakePair {
    LightMapSource& bake;  ///< of openUnpacked
    LightMapSource& repacked;
    double key;               ///< of the bake (verify::LightMapKey); the cooked map was opened with it
    verify::Viewing viewing;  ///< of the bake
};
/// Measures the errors at the covered texel centres of the bake that triangles read, and at random places of their footprints on the
/// surface, where the bake is filtered between covered texels alone.
formats::Result<UnpackedErrors> unpackedErrors(const BakePair& bakes, const UnpackedBake& unpacked,
                                               const LightMapVerifyParameters& parameters, const CookedLightMapReader& cooked,
                                               const ActionContext& context);

}  // namespace lightcook::pipeline
