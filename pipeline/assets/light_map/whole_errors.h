// Verification of what a pixel shows of a light map and its dominant light together, from the bytes of both.
//
// Method: the places of SurfacePlaces are shaded by the bake and the reference fit to it, and by both cooked assets, as a GPU filters them:
// diffuse light, area specular and the highlight of the dominant light (verify/whole_shading.h).
#pragma once

#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pipeline/assets/light_map/kept_map.h"
#include "pipeline/assets/light_map/shading.h"
#include "pipeline/assets/light_map/surface_places.h"
#include "pipeline/assets/results.h"
#include "pipeline/document/json_fields.h"
#include "pipeline/graph/action.h"
#include "pipeline/limits/limits.h"
#include "verify/whole_shading.h"

namespace lightcook::pipeline {

/// Parameters of action "verify-whole". Its input is "source"; its dependencies are the cook actions of the light map and, unless it was
/// left out, of the dominant light.
struct WholeVerifyParameters {
    SceneView view;
    std::optional<std::string> fit;              ///< of the dominant light, a name of allDominantFits(); absent: the scene needs none
    bool isDerived = false;                      ///< the shader derives it from the light map
    Limits limits = {};                          ///< on the whole
    std::optional<KeptMap> kept = std::nullopt;  ///< of the last cook; absent: the keys are those of the bake
};
template <class Fields, Is<WholeVerifyParameters> Self>
void describe(Fields& fields, Self& parameters) {
    describe(fields, parameters.view);
    fields.optional("fit", parameters.fit, "fit of the dominant light; absent: the scene needs none");
    fields.presentIf(parameters.isDerived, "derived", parameters.isDerived, "true if the shader derives the dominant light");
    fields.optional("max_visible", parameters.limits[Limit::WholeVisible], info(Limit::WholeVisible).caption);
    fields.optional("max_error", parameters.limits[Limit::WholeError], info(Limit::WholeError).caption);
    describeKeptKeys(fields, parameters.kept);
}

/// Shades places by the bake and, with a fit, by its dominant light. The whole shading of cooked textures is compared with the result.
/// Returns samples of WholeShader.
std::vector<float> shadeReference(const verify::WholeShader& shader, std::span<const SurfacePlace> places,
                                  const std::optional<verify::DominantFit>& fit, const glm::vec3& luminanceWeights);

/// Returns a WholeFigures.
formats::Result<ActionOutcome> verifyWhole(const ActionContext& context);

}  // namespace lightcook::pipeline
