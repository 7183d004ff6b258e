#include "pipeline/assets/light_map/content.h"

#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <optional>

#include "fit/dominant_light.h"
#include "lighting/radiometry.h"
#include "pipeline/assets/light_map/survey.h"
#include "pipeline/assets/results.h"
#include "pipeline/graph/parallel_for.h"
#include "pipeline/scene/dominant_fit.h"
#include "verify/light_map.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

/// Coefficients of the bands up to an order.
constexpr std::size_t coefficientsOf(int order) {
    return static_cast<std::size_t>((order + 1) * (order + 1));
}

/// Returns an estimate of the relative error without the bands above an order: over all normals of the sphere.
double truncationEstimate(const MapSurvey& survey, int order) {
    double missing = 0, all = 0;
    for (std::size_t band = 0; band < survey.energy.size(); ++band) {
        const double factor = lighting::kExitRadianceBands[band], energy = factor * factor * survey.energy[band];
        all += energy;
        if (static_cast<int>(band) > order) missing += energy;
    }
    return all > 0 ? std::sqrt(missing / all) : 0;
}

/// Returns true if a fit gives some covered texel of a strip a light. A map that has any has them at most texels, so it looks at few first.
bool hasDominantLight(const formats::LightMapStrip& strip, const fit::DominantLightOptions& options) {
    constexpr std::size_t kStride = 61;
    const auto isLit = [&](std::size_t i) {
        return strip.covered.texels()[i] != 0 &&
               fit::dominantLight(strip.sh.texels()[i], strip.normal.texels()[i], options).intensity != glm::vec3(0);
    };
    for (std::size_t first = 0; first < kStride; ++first)
        for (std::size_t i = first; i < strip.sh.texels().size(); i += kStride)
            if (isLit(i)) return true;
    return false;
}

/// Returns the rel_rms of the shading without the bands above an order.
Result<double> truncationError(LightMapSource& source, const verify::LightMapScore& score, bool isSpecular, int order,
                               const ActionContext& context) {
    verify::ShadedErrors errors;
    const auto scored = foldInOrder<verify::ShadedErrors>(
        source.chunkCount(), context, fmt::format("measure order {} of {}", order, context.action.asset),
        [&](int index) -> Result<verify::ShadedErrors> {
            LC_TRY(chunk, source.chunk(index));
            formats::Image<lighting::ShRgb> truncated((*chunk)->sh.width(), (*chunk)->sh.height());
            for (int y = 0; y < truncated.height(); ++y)
                for (int x = 0; x < truncated.width(); ++x)
                    std::copy_n((*chunk)->sh.at(x, y).begin(), coefficientsOf(order), truncated.at(x, y).begin());
            return score.score(**chunk, truncated.view(), (*chunk)->firstRow);
        },
        [&](const verify::ShadedErrors& part) { errors.merge(part); });
    if (!scored) return tl::make_unexpected(scored.error());
    const verify::ErrorFigures diffuse = errors.diffuse.figures(), specular = errors.specular.figures();
    return std::max(diffuse.relRms, isSpecular ? specular.relRms : 0.0);
}

/// Returns true if any texel has a dominant light.
Result<bool> findDominantLight(LightMapSource& source, const fit::DominantLightOptions& options, const ActionContext& context) {
    std::atomic<bool> isFound = false;
    LC_CHECK(mapInOrder<int>(source.chunkCount(), context, fmt::format("look for a dominant light in {}", context.action.asset),
                             [&](int index) -> Result<int> {
                                 if (isFound) return 0;
                                 LC_TRY(chunk, source.chunk(index));
                                 if (hasDominantLight(**chunk, options)) isFound = true;
                                 return 0;
                             }));
    return isFound;
}

/// Measures the errors without the bands above orders 0 and 1. One over the limit stays empty.
Result<void> measureOrders(LightMapSource& source, const MapSurvey& survey, const LightMapContentParameters& parameters,
                           LightMapContent& content, const ActionContext& context) {
    std::optional<verify::LightMapScore> score;
    for (const int order : {0, 1}) {
        std::optional<double>& result = order == 0 ? content.errorOfOrder0 : content.errorOfOrder1;
        const double estimate = truncationEstimate(survey, order);
        if (estimate == 0) {  // bakes of lower order, which have nothing to leave out
            result = 0;
            continue;
        }
        // The estimate is of all normals. Those that are shaded see more of the light, so the error is at most about this.
        if (estimate > 2 * parameters.maxError) continue;
        if (!score) {
            LC_TRY(created, verify::LightMapScore::create(parameters.shading, survey.key.key()));
            score = std::move(*created);
        }
        LC_TRY(error, truncationError(source, *score, parameters.shading.specular, order, context));
        if (*error <= parameters.maxError) result = *error;
    }
    return {};
}

}  // namespace

Result<ActionOutcome> readLightMapContent(const ActionContext& context) {
    LC_TRY(parameters, parametersOf<LightMapContentParameters>(context));
    LC_TRY(opened, openLightMap(context, parameters->description));
    LightMapSource& source = **opened;
    LC_TRY(survey, source.survey(context));
    const ConstantLight& light = (*survey)->light;
    LightMapContent content;
    content.width = source.width();
    content.height = source.height();
    content.covered = light.texels();
    content.isConstant = light.isConstant() && (light.hasOneNormal() || light.isIsotropic());
    content.isBlack = light.isBlack();
    content.hasOneNormal = light.hasOneNormal();
    if (parameters->dominantFit) {
        LC_TRY(fit, dominantFitOf(context.action.asset, *parameters->dominantFit));
        LC_TRY(isFound, findDominantLight(source, {.luminanceWeights = source.luminanceWeights(), .fit = (*fit)->cooked}, context));
        content.hasDominant = *isFound;
    }
    LC_CHECK(measureOrders(source, **survey, *parameters, content, context));
    return outcomeWith(content);
}

}  // namespace lightcook::pipeline
