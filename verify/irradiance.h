// An irradiance cubemap against the sum over every texel of its source. It shares nothing with the fit that made the map.
#pragma once

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <span>

#include "formats/environment.h"
#include "formats/image.h"

namespace lightcook::verify {

struct IrradianceFigures {
    int texelCount = 0;
    double relRms = 0;  ///< root of the squared error over the references' own
    double worst = 0;   ///< of a channel: |error| / (reference + 2 % of the mean radiance)
};

/// faces: six of one size, decoded, over `range`. Up to 96 texels, evenly spread, each against
/// integral of L max(0, n.l + wrap) / (pi (1 + wrap)^2): every source texel by its solid angle, in its middle, over the sum of the weights.
IrradianceFigures compareIrradiance(std::span<const formats::Image<glm::vec4>> faces, float range, double wrap,
                                    const formats::Environment& environment);

}  // namespace lightcook::verify
