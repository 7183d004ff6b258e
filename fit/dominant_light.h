// The dominant light: one directional light that approximates a texel's SH, as it is stored in textures. Closed form, or the best of all
// directions (light_search.h). docs/theory/lighting.md, "Dominant light".
//
// The stored direction is not normalised. Its length is the directionality, so that texture filtering weighs neighbours sensibly; the
// shader filters first and normalises after. Where the directionality is low, direction and intensity fade to the normal and to 0.
// fit/filtered_light.h fits the lights of neighbouring texels together, for the light that a filter shows between them.
// Source: Chen and Liu 2008, Lighting and Material of Halo 3, section 1.4.1.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "formats/image.h"
#include "lighting/sh.h"

namespace lightcook::fit {

enum class DominantFit {
    Closed,         ///< direction of band 1, intensity by least squares
    Refined,        ///< direction and intensity by least squares
    Explained,      ///< the same, dimmed where one light explains the SH badly; the rest is shaded as area specular
    RefinedAmbient  ///< with an ambient term, which is not stored: it is coefficient 0 minus the light's part of it
};

struct DominantLightOptions {
    glm::vec3 luminanceWeights = lighting::kRec709Luminance;  ///< of the working colour space
    /// Directionality |band 1| / (sqrt(3) lambda_0) under which the direction is noise. With t = smoothstep(fadeStart, fadeEnd,
    /// directionality) the stored vector is t v + (1 - t) fadeEnd n and the intensity is scaled by t. 0 <= fadeStart < fadeEnd <= 1.
    float fadeStart = 0.02f;
    float fadeEnd = 0.08f;
    DominantFit fit = DominantFit::Closed;
    /// For Explained. With e = root of the squared error over the norm of the coefficients: the light is dimmed from e = dimStart and gone
    /// at e = dimEnd.
    float dimStart = 0.3f, dimEnd = 0.4f;
    /// For the refined fits: a texel is not searched if the e of its closed form exceeds the lower bound of e for any light by at most
    /// this.
    float tolerance = 1e-3f;
};

struct DominantLight {
    /// Towards the light, in the unit ball, not normalised: v = band 1 / (sqrt(3) lambda_0) of the luminance, clamped to length 1 (refined:
    /// turned to the direction found), faded to fadeEnd * normal. Never zero for a unit normal, so that the shader may filter first and
    /// normalise after.
    glm::vec3 direction{0};
    /// Radiometric delta per channel, >= 0, faded: c = (4pi / 9) sum lambda_i Y_i(normalize(direction)). With positive ambient light
    /// the sum starts at i = 1 and the factor is pi / 2.
    glm::vec3 intensity{0};
    float directionality = 0;  ///< in [0, 1]: 1 for a single directional light, 0 for light without a direction
    bool isSearched = false;   ///< the refined fit searched for a better direction
};

/// Counts of covered texels.
struct DominantCounts {
    std::int64_t refined = 0;  ///< searched by the refined fit
    std::int64_t skipped = 0;  ///< closed form kept: black, faded out, or within the tolerance
};

/// Fits the light of one texel. Finite for every finite input; a DC of 0 or less has directionality 0.
/// incident  radiance, in the frame of the normal
/// normal    unit; (0, 0, 1) replaces a zero normal
DominantLight dominantLight(const lighting::ShRgb& incident, const glm::vec3& normal, const DominantLightOptions& options);

/// Rows of a map and of the textures of its lights, all of one size.
struct DominantLightRows {
    formats::ImageView<const lighting::ShRgb> sh;
    formats::ImageView<const std::uint8_t> covered;
    formats::ImageView<const glm::vec3> normal;
    formats::ImageView<glm::vec3> direction, intensity;  ///< DominantLight of each texel
    /// Chart of each texel, as LightMapStrip::chart; read by fitForFilter(). Empty: surfaces lie between all covered texels.
    formats::ImageView<const std::uint32_t> chart = {};
};

/// Sets the lights of all texels; threads may share the rows of a map. Lights of texels that are not covered become zero: the caller pads
/// them.
DominantCounts fitDominantLights(const DominantLightRows& rows, const DominantLightOptions& options);

/// Returns an upper bound of the intensity of any fit of this texel, at most about twice the intensity of the best light.
float largestIntensity(const lighting::ShRgb& incident);

}  // namespace lightcook::fit
