#include "pipeline/lint/gradient_facts.h"

#include <algorithm>
#include <vector>

#include "formats/environment.h"
#include "pipeline/assets/results.h"
#include "pipeline/assets/rsrm/rsrm.h"
#include "pipeline/assets/source_colors.h"

namespace lightcook::pipeline {
namespace {

formats::Result<std::vector<glm::vec3>> texelsOf(const GradientLintParameters& parameters, const Action& action) {
    const std::filesystem::path& file = action.inputs.at("source");
    const formats::EnvironmentOptions options{withConfig(parameters.colors, action), parameters.repair};
    if (!parameters.isEnvironment)
        return formats::loadPaintedGradient(file, options, encodingOf(parameters.encoding)).map([](formats::PaintedGradient painted) {
            return std::move(painted.zones);
        });
    LC_TRY(loaded, formats::loadEnvironment(file, options));
    return std::move(loaded->environment.texels.texels());
}

}  // namespace

formats::Result<ActionOutcome> lintGradient(const ActionContext& context) {
    LC_TRY(parameters, parametersOf<GradientLintParameters>(context));
    LC_TRY(texels, texelsOf(*parameters, context.action));
    GradientFacts facts;
    facts.primaries = formats::statedPrimaries(context.action.inputs.at("source"), withConfig(parameters->colors, context.action));
    for (const glm::vec3& texel : *texels) facts.largest = std::max(facts.largest, 1.0 * std::max({texel.x, texel.y, texel.z}));
    return outcomeWith(facts);
}

}  // namespace lightcook::pipeline
