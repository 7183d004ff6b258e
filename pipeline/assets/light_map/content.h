// Content of a light map that decides how little of it must be cooked: constant light, and bands that no shading shows.
#pragma once

#include <cstdint>
#include <optional>

#include "pipeline/assets/light_map/shading.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// Parameters of the action "light-map-content". Its input is "source".
struct LightMapContentParameters {
    formats::LightMapDescription description;
    verify::LightMapShading shading;
    double maxError = 0.02;                       ///< limit on rel_rms: larger errors of a lower order are not measured
    std::optional<std::string> dominantFit = {};  ///< a name of allDominantFits(); absent: nothing needs the dominant light
};
template <class Fields, Is<LightMapContentParameters> Self>
void describe(Fields& fields, Self& parameters) {
    fields.required("description", parameters.description, "conventions of the light map");
    fields.required("shading", parameters.shading, "materials that are shaded");
    fields.required("max_error", parameters.maxError, "limit on rel_rms");
    fields.optional("dominant_fit", parameters.dominantFit, "fit of the dominant light; absent: nothing needs it");
}

struct LightMapContent {
    int width = 0, height = 0;
    std::int64_t covered = 0;   ///< texels
    bool isConstant = false;    ///< every covered texel has the same coefficients, and the same exit radiance at its own normal
    bool isBlack = false;       ///< isConstant, and that radiance is 0
    bool hasOneNormal = false;  ///< every covered texel has the same normal
    bool hasDominant = true;    ///< false: the fit gives no covered texel a dominant light
    /// rel_rms of the shading, the larger of diffuse and specular, without the bands above 0 and above 1. Empty if it exceeds max_error.
    std::optional<double> errorOfOrder0, errorOfOrder1;
};
template <class Fields, Is<LightMapContent> Self>
void describe(Fields& fields, Self& content) {
    fields.required("width", content.width, between(1, kLargestSide), "width [texels]");
    fields.required("height", content.height, between(1, kLargestSide), "height [texels]");
    fields.required("covered", content.covered, "covered texels");
    fields.required("is_constant", content.isConstant, "true if every covered texel holds the same light");
    fields.required("is_black", content.isBlack, "true if that is none");
    fields.required("has_one_normal", content.hasOneNormal, "true if every covered texel has the same normal");
    fields.required("has_dominant", content.hasDominant, "false if the fit gives no covered texel a dominant light");
    fields.optional("error_of_order_0", content.errorOfOrder0, kFigure, "rel_rms of shading with band 0 alone");
    fields.optional("error_of_order_1", content.errorOfOrder1, kFigure, "rel_rms of shading with bands 0 and 1");
}

formats::Result<ActionOutcome> readLightMapContent(const ActionContext& context);

}  // namespace lightcook::pipeline
