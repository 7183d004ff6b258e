// One directional light that explains a texel's SH best: the closed form. Source: Chen and Liu, Lighting and Material of Halo 3,
// section 1.4.1, with lighting-math section 3 (the denominator sum Y_i^2 is the constant 9/4pi; directions are stored so that texture
// filtering keeps a meaning).
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "formats/image.h"
#include "lighting/sh.h"

namespace fit {

struct DominantLightOptions {
    glm::vec3 luminanceWeights = lighting::kRec709Luminance;  ///< of the working colour space
    /// Directionality |band 1| / (sqrt(3) lambda_0) under which the direction is noise. With t = smoothstep(fadeStart, fadeEnd,
    /// directionality) the stored vector is t v + (1 - t) fadeEnd n and the intensity is scaled by t. 0 <= fadeStart < fadeEnd <= 1.
    float fadeStart = 0.02f;
    float fadeEnd = 0.08f;
};

struct DominantLight {
    /// Towards the light, in the unit ball, not normalised: v = band 1 / (sqrt(3) lambda_0) of the luminance, clamped to length 1, faded to
    /// fadeEnd * normal. Never zero for a unit normal, so that the shader may filter first and normalise after.
    glm::vec3 direction{0};
    glm::vec3 intensity{0};    ///< radiometric delta per channel, c = (4pi / 9) sum lambda_i Y_i(normalize(direction)), >= 0, faded
    float directionality = 0;  ///< in [0, 1]: 1 is a single directional light, 0 tells nothing of a direction
};

/// incident: radiance, world frame (of the normal). normal: unit; a zero normal leaves (0, 0, 1) in its place.
/// Finite for every finite input: a DC at or under zero has directionality 0.
DominantLight dominantLight(const lighting::ShRgb& incident, const glm::vec3& normal, const DominantLightOptions& options);

/// All texels of views of one size; rows may be split over threads. Texels that are not covered get zero: their caller dilates.
void dominantLight(formats::ImageView<const lighting::ShRgb> sh, formats::ImageView<const std::uint8_t> covered,
                   formats::ImageView<const glm::vec3> normal, const DominantLightOptions& options, formats::ImageView<glm::vec3> direction,
                   formats::ImageView<glm::vec3> intensity);

}  // namespace fit
