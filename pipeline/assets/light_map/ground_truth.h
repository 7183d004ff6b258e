// Traced light beside a light map ([[light_map]] ground_truth): which values fall where, and what the report says of them.
#pragma once

#include <span>
#include <vector>

#include "formats/light_map.h"
#include "formats/shading_values.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/graph/action.h"
#include "verify/dominant.h"
#include "verify/ground_truth.h"

namespace lightcook::pipeline {

/// Input of the verify actions of a light map and of its dominant light.
inline constexpr const char* kGroundTruthRole = "ground_truth";

/// The values of one file in working colour, in the order of their texels. Empty where the action has no such input.
class GroundTruth {
public:
    /// description: of the light map, whose source colour space the values share.
    static formats::Result<GroundTruth> open(const ActionContext& context, const LightMapSource& bake, const Json& description);
    bool isEmpty() const { return values_.empty(); }

    /// Values in rows [firstRow, firstRow + rowCount), which the band must hold; refuses one outside every chart.
    formats::Result<std::span<const formats::ShadingValue>> within(const formats::LightMapStrip& band, int firstRow, int rowCount) const;

private:
    std::string file_;
    std::vector<formats::ShadingValue> values_;
};

/// cooked: as the shader reads it, rows from firstRow on.
std::vector<verify::LightMapTruthPlace> lightMapPlaces(std::span<const formats::ShadingValue> values, const formats::LightMapStrip& band,
                                                       const formats::Image<lighting::ShRgb>& cooked, int firstRow);

/// Of the specular ones, with the lights that the texels hold and should hold; texels: rows that hold those of the values.
std::vector<verify::DominantTruthPlace> dominantPlaces(std::span<const formats::ShadingValue> values, const formats::LightMapStrip& band,
                                                       const verify::DominantVerifier& verifier, const verify::DecodedDominantRows& texels,
                                                       bool hasAmbient);

/// {"values", "lambert": {"truncation", "quantization", "total"}, "area_specular": the same and "by_m": [{"m", ...}]}
Json toJson(const verify::LightMapTruth& truth);
/// {"values", "specular": {"truncation", "fit", "quantization", "total", "with_rest", "two_lights", "by_m"}, "fit_is_largest"}: truncation
/// is that of area specular from the nine coefficients; two_lights is what `fit` would be with a second light.
Json toJson(const verify::DominantTruth& truth);

}  // namespace lightcook::pipeline
