// Coverage of a bake whose file says nothing: what has light lies inside charts, and so does what lies between such texels.
#pragma once

#include <memory>

#include "formats/bakes/bake_reader.h"

namespace lightcook::formats {

/// Returns the bake with this coverage, in place of its own. A texel without light is a gap unless texels with light lie on two opposite
/// sides of it, at most two texels away: along its row, its column or a diagonal. So a narrow shadow inside a chart stays black, and the
/// texels around a chart, which are black where no baker grew its light, are none of it.
std::unique_ptr<BakeReader> coveredByLight(std::unique_ptr<BakeReader> bake);

}  // namespace lightcook::formats
