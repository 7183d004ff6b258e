// Comparison of shading from cooked assets with path-traced ground truth, split by cause: truncation to nine coefficients, the model of one
// directional light, and cooking.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "formats/shading_values.h"
#include "lighting/brdf.h"
#include "lighting/sh.h"
#include "verify/dominant.h"
#include "verify/visible.h"

namespace lightcook::verify {

/// RMS errors over the RMS of the truth, over all channels of all values.
struct TruthErrors {
    double model = 0;    ///< shading from the float data against the truth: independent of the cook
    double cooking = 0;  ///< shading from the cooked data against shading from the float data
    double total = 0;    ///< shading from the cooked data against the truth
};

/// Sums of squares for TruthErrors.
class TruthSums {
public:
    void add(const glm::dvec3& truth, const glm::dvec3& fromFloats, const glm::dvec3& fromCooked);
    void merge(const TruthSums& other);
    TruthErrors errors() const;  ///< 0 if nothing was added; the largest double for an error over black
    std::int64_t count() const { return count_; }

private:
    std::int64_t count_ = 0;
    double truth_ = 0, model_ = 0, cooking_ = 0, total_ = 0;
};

/// The same as a display shows it: visible errors (docs/theory/visible.md) of shading from the cooked data. Without samples where no
/// viewing was given.
struct TruthVisible {
    VisibleAccumulator cooking;  ///< against shading from the float data
    VisibleAccumulator total;    ///< against the truth
};

/// A traced value, and the coefficients at its texel: of the bake, and as the shader decodes them from the cooked map. World frame, no
/// Condon-Shortley sign.
struct LightMapTruthPlace {
    formats::ShadingValue value;
    glm::dvec3 normal{0, 0, 1};
    lighting::ShRgb baked{}, cooked{};
};
struct LightMapTruth {
    TruthSums lambert;                         ///< model error: truncation to nine coefficients, and noise of the bake
    std::map<double, TruthSums> areaSpecular;  ///< [m], from the coefficients alone with exact kernels
    TruthVisible visibleLambert;               ///< of a white surface
};
/// lobe     of the traced surfaces, and of the scene
/// viewing  empty: no visible errors
LightMapTruth lightMapTruth(std::span<const LightMapTruthPlace> places,
                            lighting::NormalDistribution lobe = lighting::NormalDistribution::Beckmann,
                            const std::optional<Viewing>& viewing = std::nullopt);

/// Median ratio of traced light to that of the bake: 1 where both are in one unit.
struct TracedRatio {
    double ratio = 1;
    bool isSpecular = false;  ///< of specular light, since no irradiance was traced: highlights of small lamps make it anything near 1
};

/// Returns the ratio of the places where nine coefficients tell it; nothing where few do. With x the cosine to a light, coefficients show
/// p(x) = 1/4 + x/2 + 5/32 (3 x^2 - 1) for max(x, 0), and -0.040 <= p(x) - max(x, 0) <= 0.094. So of all light F at a place they show at
/// most 0.094 F too much; where they show 0.3 F or more, the ratio lies in [0.68, 1.14] whatever the light, but for noise. Light that
/// grazes the surface shows less, and does not count; nor do places darker than a twentieth of the mean, which noise may decide.
std::optional<TracedRatio> tracedRatio(std::span<const LightMapTruthPlace> places);

/// A traced value of kind Specular, and the lights at its texel.
struct DominantTruthPlace {
    formats::ShadingValue value;
    glm::dvec3 normal{0, 0, 1};
    lighting::ShRgb baked{};
    DominantLightSample fitted, cooked;        ///< fitted to the float coefficients; stored in the textures
    std::array<DominantLightSample, 2> two{};  ///< two lights fitted to the same coefficients
};
struct DominantTruth {
    std::map<double, TruthSums> oneLight;      ///< [m], the shipped analytic specular. Model error: one light for all
    std::map<double, TruthSums> withRest;      ///< the light, and area specular of the coefficients that it does not explain
    std::map<double, TruthSums> twoLights;     ///< two lights, uncompressed, in place of the cooked ones; model as in oneLight
    std::map<double, TruthSums> areaSpecular;  ///< of the bake's coefficients, uncompressed. Model error: nine coefficients
    TruthVisible visibleWithRest;              ///< of all specular light, as withRest
};
DominantTruth dominantTruth(std::span<const DominantTruthPlace> places,
                            lighting::NormalDistribution lobe = lighting::NormalDistribution::Beckmann,
                            const std::optional<Viewing>& viewing = std::nullopt);

/// Returns the sums over all m.
TruthSums sumOf(const std::map<double, TruthSums>& byM);

}  // namespace lightcook::verify
