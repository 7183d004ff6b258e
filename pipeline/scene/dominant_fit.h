// Fits of the dominant light: one table, from which the scene file, the command line, the cook and its verification derive.
#pragma once

#include <span>
#include <string_view>

#include "fit/dominant_light.h"
#include "formats/error.h"
#include "verify/dominant.h"

namespace lightcook::pipeline {

struct DominantFitInfo {
    std::string_view name;     ///< value of `dominant_fit` and `dominant --fit`, and `fit` of the manifest
    std::string_view caption;  ///< for help and documents
    fit::DominantFit cooked;
    verify::DominantFit verified;
};

/// Returns every fit, the default first.
std::span<const DominantFitInfo> allDominantFits();

/// Returns the fit of a name; nullptr for other names.
const DominantFitInfo* dominantFitFromName(std::string_view name);
/// Returns the same; fails for other names.
/// asset  name of the dominant light, for the message
formats::Result<const DominantFitInfo*> dominantFitOf(const std::string& asset, std::string_view name);

/// Returns true if the light of a fit is the one that a shader derives from a light map's coefficients.
bool isDerivable(std::string_view fit);

}  // namespace lightcook::pipeline
