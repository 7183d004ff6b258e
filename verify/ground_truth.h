// What shading from cooked assets is worth against light that somebody else traced, and whose fault the difference is: what nine
// coefficients cannot say, what one light cannot say, and what cooking lost.
#pragma once

#include <array>
#include <cstdint>
#include <glm/vec3.hpp>
#include <map>
#include <span>
#include <vector>

#include "formats/shading_values.h"
#include "lighting/sh.h"
#include "verify/assets/dominant_reference.h"

namespace lightcook::verify {

/// RMS errors over the RMS of the truth, all channels of all values.
struct TruthErrors {
    double model = 0;    ///< shading from the float data, against the truth: not the cook's
    double cooking = 0;  ///< shading from the cooked data, against that from the float data
    double total = 0;    ///< shading from the cooked data, against the truth
};

/// Sums of squares of one way to shade.
class TruthSums {
public:
    void add(const glm::dvec3& truth, const glm::dvec3& fromFloats, const glm::dvec3& fromCooked);
    void merge(const TruthSums& other);
    TruthErrors errors() const;  ///< 0 where nothing was added; the largest double for an error over black
    std::int64_t count() const { return count_; }

private:
    std::int64_t count_ = 0;
    double truth_ = 0, model_ = 0, cooking_ = 0, total_ = 0;
};

/// A value, and the coefficients at its texel: the bake's, and what the shader reads from the cooked map. World frame, canonical phase.
struct LightMapTruthPlace {
    formats::ShadingValue value;
    glm::dvec3 normal{0, 0, 1};
    lighting::ShRgb baked{}, cooked{};
};
struct LightMapTruth {
    TruthSums lambert;                         ///< model: truncation to nine coefficients, and the baker's noise
    std::map<double, TruthSums> areaSpecular;  ///< by m; from the coefficients alone, exact kernels
};
LightMapTruth lightMapTruth(std::span<const LightMapTruthPlace> places);

/// A value of kind Specular, and the lights at its texel.
struct DominantTruthPlace {
    formats::ShadingValue value;
    glm::dvec3 normal{0, 0, 1};
    lighting::ShRgb baked{};
    DominantLightSample fitted, cooked;        ///< of the float coefficients; in the textures
    std::array<DominantLightSample, 2> two{};  ///< what a second light would make of the same coefficients
};
struct DominantTruth {
    std::map<double, TruthSums> oneLight;      ///< by m; the shipped analytic specular. model: what one light cannot say
    std::map<double, TruthSums> withRest;      ///< the light, and area specular of what it leaves of the bake's coefficients
    std::map<double, TruthSums> twoLights;     ///< "cooked": two lights, uncompressed; model as above
    std::map<double, TruthSums> areaSpecular;  ///< of the bake's coefficients, uncompressed: what nine coefficients cannot say
};
DominantTruth dominantTruth(std::span<const DominantTruthPlace> places);

/// All m together.
TruthSums sumOf(const std::map<double, TruthSums>& byM);

}  // namespace lightcook::verify
