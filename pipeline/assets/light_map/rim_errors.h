// Law on the texels beside charts, which a filter on a surface reads too: at the rim of a chart light may be off by no more than the texels
// of the chart beside it explain. Random places of the surface often miss a single wrong texel there.
#pragma once

#include <string>
#include <vector>

#include "pipeline/assets/light_map/cooked_light_map.h"
#include "verify/block_errors.h"
#include "verify/violation.h"

namespace lightcook::pipeline {

/// Adds the place at a rim that errs most, of each block, to the errors of a strip's blocks. An error counts beside the brightest covered
/// texel next to the one outside, since that one may hold the mean of them.
/// rims  one for each block of the strip's rows
/// key   of the map
formats::Result<void> addRimErrors(LightMapSource& bake, const CookedLightMapReader& cooked, const CookedStrip& strip, bool isFlat,
                                   double key, verify::BlockErrors& rims);

/// Adds a violation for the worst rim if it is over the limit.
/// image  prefix of the place: "mip 1, "
void checkRims(const verify::BlockErrors& rims, const std::string& image, double maxError, std::vector<verify::Violation>& violations);

}  // namespace lightcook::pipeline
