// The floor of a bake: the error on its surface that no filtered layout avoids.
//
// The reference of a place is the bake, filtered between covered texels alone. A GPU filters all four texels, so the texels outside charts
// have to serve the places beside them, those of two charts at once where one texel lies between both. Layout raw, without blocks, with
// these texels solved for the places (compress/light_map/filter_fit.h), is the best that a filtered texture can do: a limit below its
// errors cannot be kept. Between four covered texels raw is exact, so only places at rims are shaded.
#pragma once

#include <array>
#include <optional>

#include "pipeline/assets/light_map/shading.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/assets/results.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// Parameters of the action "light-map-floor". Its input is "source".
struct LightMapFloorParameters {
    formats::LightMapDescription description;
    verify::LightMapShading shading;
    lighting::DisplaySettings display;
};
template <class Fields, Is<LightMapFloorParameters> Self>
void describe(Fields& fields, Self& parameters) {
    fields.required("description", parameters.description, "conventions of the light map");
    fields.required("shading", parameters.shading, "materials that are shaded");
    fields.required("display", parameters.display, "display that visible errors are judged on");
}

/// Errors of the bake at up to 131072 places, spread evenly over its surface. They are a sample: the 99th percentile is that of 1300 places
/// above it, and differs from that of all places by a few percent.
struct LightMapFloor {
    double relRms = 0;                           ///< the larger of diffuse and specular
    double visible = 0;                          ///< 99th percentile, the larger of diffuse and specular
    std::optional<std::array<double, 2>> texel;  ///< of the largest visible error; absent: there is none
    double rimShare = 0;                         ///< of the surface: places where a filter reads a texel outside charts
};
template <class Fields, Is<LightMapFloor> Self>
void describe(Fields& fields, Self& floor) {
    fields.required("rel_rms", floor.relRms, kFigure, "RMS of the error over RMS of the reference");
    fields.required("visible", floor.visible, kFigure, "99th percentile of the visible errors");
    fields.optional("texel", floor.texel, "place of the largest visible error");
    fields.required("rim_share", floor.rimShare, kFigure, "share of the surface that lies at rims of charts");
}

formats::Result<ActionOutcome> measureFloor(const ActionContext& context);

}  // namespace lightcook::pipeline
