// The dominant light of each texel of a light map: a direction that can be filtered, and an HDR intensity. docs/theory/lighting.md,
// "Dominant light".
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "formats/target.h"
#include "pipeline/assets/light_map/shading.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/assets/textures.h"
#include "pipeline/document/json_fields.h"
#include "pipeline/graph/action.h"
#include "pipeline/limits/limits.h"

namespace lightcook::pipeline {

/// Parameters of the cook action. Its input is "source".
struct DominantParameters {
    formats::LightMapDescription description;
    std::string fit;  ///< a name of allDominantFits()
    formats::Target target = formats::Target::Bc;
    TextureSettings textures;
    std::optional<std::string> lightMap = {};
};
template <class Fields, Is<DominantParameters> Self>
void describe(Fields& fields, Self& parameters) {
    fields.required("description", parameters.description, "conventions of the light map");
    fields.required("fit", parameters.fit, "fit of the light");
    fields.required("target", parameters.target, "target");
    fields.required("textures", parameters.textures, "settings of the files");
    fields.optional("light_map", parameters.lightMap, "name of the light map");
}

/// Constants of the shader's decode: direction = direction_scale * stored + direction_bias, where stored is the texel of "direction", to
/// which the texel of "residual" adds residual_scale * (texel - residual_centre); intensity = intensity_range * texel.
struct DominantConstants {
    float directionScale = 1, directionBias = 0;
    float residualScale = 0;  ///< 0: there is no texture "residual"
    float residualCentre = 0;
    float intensityRange = 1;
};
template <class Fields, Is<DominantConstants> Self>
void describe(Fields& fields, Self& constants) {
    fields.required("direction_scale", constants.directionScale, "factor of the stored direction");
    fields.required("direction_bias", constants.directionBias, "offset of the stored direction");
    fields.required("residual_scale", constants.residualScale, "factor of the residual texture; 0: there is none");
    fields.required("residual_centre", constants.residualCentre, "stored value of a zero residual");
    fields.required("intensity_range", constants.intensityRange, "factor of the stored intensity");
}

/// Parameters of the verify action.
struct DominantVerifyParameters {
    SceneView view;
    Limits limits;
};
template <class Fields, Is<DominantVerifyParameters> Self>
void describe(Fields& fields, Self& parameters) {
    describe(fields, parameters.view);
    describe(fields, parameters.limits, kAssetLimits);
}

/// Adds a decoded residual to decoded directions: then they are as the shader's lcDominantStored has them.
void addResidual(formats::Image<glm::vec4>& directions, const formats::Image<glm::vec4>& residual, const DominantConstants& constants);

/// Returns the formats of the textures of a target.
std::vector<formats::PixelFormat> dominantFormats(formats::Target target);

formats::Result<ActionOutcome> cookDominant(const ActionContext& context);
/// Verifies the shaded light of the cooked textures against that of the fit to the bake. Parameters are a SceneView, beside max_error;
/// inputs are "source" and optionally traced light.
formats::Result<ActionOutcome> verifyDominant(const ActionContext& context);

}  // namespace lightcook::pipeline
