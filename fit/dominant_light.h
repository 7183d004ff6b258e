// One directional light that stands for a texel's SH: the closed form, or the best of all directions, as it is stored in textures. Source:
// Chen and Liu, Lighting and Material of Halo 3, section 1.4.1, with lighting-math section 3 (the denominator sum Y_i^2 is the constant
// 9/4pi; directions are stored so that texture filtering keeps a meaning). light_search.h says what the refined fit makes small.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "formats/image.h"
#include "lighting/sh.h"

namespace lightcook::fit {

enum class DominantFit {
    Closed,         ///< direction of band 1, intensity by least squares
    Refined,        ///< direction and intensity by least squares
    Explained,      ///< the same, dimmed where one light leaves much: beside it area specular of the rest is meant to be shaded
    RefinedAmbient  ///< beside them an ambient term, which is not stored: it is what the intensity leaves of coefficient 0
};

struct DominantLightOptions {
    glm::vec3 luminanceWeights = lighting::kRec709Luminance;  ///< of the working colour space
    /// Directionality |band 1| / (sqrt(3) lambda_0) under which the direction is noise. With t = smoothstep(fadeStart, fadeEnd,
    /// directionality) the stored vector is t v + (1 - t) fadeEnd n and the intensity is scaled by t. 0 <= fadeStart < fadeEnd <= 1.
    float fadeStart = 0.02f;
    float fadeEnd = 0.08f;
    DominantFit fit = DominantFit::Closed;
    /// Of Explained: what the light leaves (root of the squared error over the norm of the coefficients) from which it is dimmed, and from
    /// which there is none.
    float dimStart = 0.3f, dimEnd = 0.4f;
    /// Of the refined fits: a texel whose closed form is proven to leave at most this much more than any light could is not searched. What
    /// is left is the root of the squared error over the norm of the coefficients.
    float tolerance = 1e-3f;
};

struct DominantLight {
    /// Towards the light, in the unit ball, not normalised: v = band 1 / (sqrt(3) lambda_0) of the luminance, clamped to length 1 (refined:
    /// turned to the direction found), faded to fadeEnd * normal. Never zero for a unit normal, so that the shader may filter first and
    /// normalise after.
    glm::vec3 direction{0};
    /// Radiometric delta per channel, >= 0, faded: c = (4pi / 9) sum lambda_i Y_i(normalize(direction)); beside ambient light that is at
    /// least 0 the sum runs from 1 and the factor is pi / 2.
    glm::vec3 intensity{0};
    float directionality = 0;  ///< in [0, 1]: 1 is a single directional light, 0 tells nothing of a direction
    bool isSearched = false;   ///< the refined fit looked for a better direction
};

/// Of the covered texels: how many the refined fit searched, and how many it could leave as the closed form has them (black ones, those
/// with no direction to speak of, and those within the tolerance).
struct DominantCounts {
    std::int64_t refined = 0, skipped = 0;
};

/// incident: radiance, world frame (of the normal). normal: unit; a zero normal leaves (0, 0, 1) in its place.
/// Finite for every finite input: a DC at or under zero has directionality 0.
DominantLight dominantLight(const lighting::ShRgb& incident, const glm::vec3& normal, const DominantLightOptions& options);

/// All texels of views of one size; rows may be split over threads. Texels that are not covered get zero: their caller dilates.
DominantCounts dominantLight(formats::ImageView<const lighting::ShRgb> sh, formats::ImageView<const std::uint8_t> covered,
                             formats::ImageView<const glm::vec3> normal, const DominantLightOptions& options,
                             formats::ImageView<glm::vec3> direction, formats::ImageView<glm::vec3> intensity);

/// No intensity of any fit of this texel is above it; within a factor of 2 or so of what one light needs.
float largestIntensity(const lighting::ShRgb& incident);

}  // namespace lightcook::fit
