// Strips of a light map at a fraction of its size, for dominant lights that are smaller than their light map.
#pragma once

#include <glm/vec2.hpp>

#include "formats/light_map.h"

namespace lightcook::pipeline {

/// Returns the size of a map at 1 / divisor of its width and height, rounded up.
inline glm::ivec2 reducedSize(const glm::ivec2& size, int divisor) {
    return (size + glm::ivec2(divisor - 1)) / divisor;
}

/// Returns a strip at 1 / divisor of its width and height. A texel has the mean coefficients and the mean normal of the covered texels
/// that it stands for, and is covered if one of them is.
/// strip  its first row is a multiple of `divisor`; so is its row count, except at the map's end
formats::LightMapStrip reducedStrip(const formats::LightMapStrip& strip, int divisor);

}  // namespace lightcook::pipeline
