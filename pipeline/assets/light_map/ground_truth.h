// Traced light beside a light map ([[light_map]] ground_truth): its values by rows of the map, and its errors for the report.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "formats/light_map.h"
#include "formats/shading_values.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/assets/light_map/strip_digest.h"
#include "pipeline/graph/action.h"
#include "verify/dominant.h"
#include "verify/ground_truth.h"

namespace lightcook::pipeline {

/// Input of the verify actions of a light map and of its dominant light.
inline constexpr const char* kGroundTruthRole = "ground_truth";

/// Values of one file in working colour, in the order of their texels. Empty if the action has no such input.
class GroundTruth {
public:
    /// colors  of the light map: the values share its source colour space
    static formats::Result<GroundTruth> open(const ActionContext& context, const LightMapSource& bake, const formats::ColorSpaces& colors);
    bool isEmpty() const { return values_.empty(); }
    /// Returns a digest of the values.
    std::string digest() const { return digestOf(values_); }

    /// Returns the values in rows [firstRow, firstRow + rowCount), which the strip must hold; refuses one outside every chart, and a
    /// view from below the surface.
    formats::Result<std::span<const formats::ShadingValue>> within(const formats::LightMapStrip& strip, int firstRow, int rowCount) const;

private:
    std::filesystem::path file_;
    std::vector<formats::ShadingValue> values_;
};

/// Returns the values with the baked texels.
std::vector<verify::LightMapTruthPlace> bakedPlaces(std::span<const formats::ShadingValue> values, const formats::LightMapStrip& strip);
/// Returns the values with the baked and the cooked texels.
/// cooked   as the shader reads it, rows from firstRow on
std::vector<verify::LightMapTruthPlace> lightMapPlaces(std::span<const formats::ShadingValue> values, const formats::LightMapStrip& strip,
                                                       const formats::Image<lighting::ShRgb>& cooked, int firstRow);

/// Returns the dominant light that a shader has at a place.
using CookedLight = std::function<verify::DominantLightSample(const verify::LightMapTruthPlace& place)>;
/// Returns the specular values with the lights of the cooked texels, of the fit, and of a fit of two lights.
std::vector<verify::DominantTruthPlace> dominantPlaces(std::span<const verify::LightMapTruthPlace> places,
                                                       const verify::DominantVerifier& verifier, bool hasAmbient,
                                                       const CookedLight& cookedLight);

/// Returns {"values", "lambert": {"truncation", "quantization", "total", "visible"}, "area_specular": the same but "visible", and "by_m":
/// [{"m", ...}]}. visible: {"quantization", "total"} with figures of visible errors.
Json toJson(const verify::LightMapTruth& truth);
/// Returns {"values", "specular": {"truncation", "fit", "quantization", "total", "with_rest", "two_lights", "by_m", "visible"},
/// "fit_is_largest"}.
/// truncation is the error of area specular from the nine coefficients; two_lights is that of a fit with a second light.
Json toJson(const verify::DominantTruth& truth);

}  // namespace lightcook::pipeline
