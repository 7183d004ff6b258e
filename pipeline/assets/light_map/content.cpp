#include "pipeline/assets/light_map/content.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <glm/geometric.hpp>
#include <optional>
#include <utility>

#include "fit/dominant_light.h"
#include "lighting/radiometry.h"
#include "pipeline/assets/light_map/constant_light.h"
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

/// Energy of the exit radiance by band, summed over covered texels, and whether the light is constant.
struct Survey {
    ConstantLight light;
    std::array<double, 3> energy{};

    void add(const formats::LightMapStrip& strip) {
        light.add(strip);
        for (int y = 0; y < strip.sh.height(); ++y)
            for (int x = 0; x < strip.sh.width(); ++x)
                if (strip.covered.at(x, y) != 0) addEnergy(lighting::convolve(strip.sh.at(x, y), lighting::kExitRadianceBands));
    }
    void merge(const Survey& next) {
        light.merge(next.light);
        for (std::size_t band = 0; band < energy.size(); ++band) energy[band] += next.energy[band];
    }
    /// Returns an estimate of the relative error without the bands above an order: over all normals of the sphere.
    double errorOf(int order) const {
        double missing = 0, all = 0;
        for (std::size_t band = 0; band < energy.size(); ++band) {
            all += energy[band];
            if (static_cast<int>(band) > order) missing += energy[band];
        }
        return all > 0 ? std::sqrt(missing / all) : 0;
    }

private:
    void addEnergy(const lighting::ShRgb& exit) {
        for (std::size_t i = 0; i < exit.size(); ++i)
            energy[i == 0 ? 0 : i < 4 ? 1 : 2] += glm::dot(glm::dvec3(exit[i]), glm::dvec3(exit[i]));
    }
};

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

/// Returns the score that truncated maps are measured with.
Result<verify::LightMapScore> scoreOf(LightMapSource& source, const LightMapContentParameters& parameters, const ActionContext& context) {
    LC_TRY(key, surveyKey(source, context));
    return verify::LightMapScore::create(parameters.shading, key->key());
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

/// Surveys a light map.
/// hasDominant  true: the caller does not ask; else gets whether any texel has a dominant light
Result<Survey> surveyContent(LightMapSource& source, const fit::DominantLightOptions& options, bool& hasDominant,
                             const ActionContext& context) {
    std::atomic<bool> isFound = hasDominant;
    Survey survey;
    const auto surveyed = foldInOrder<Survey>(
        source.chunkCount(), context, fmt::format("survey the content of {}", context.action.asset),
        [&](int index) -> Result<Survey> {
            LC_TRY(chunk, source.chunk(index));
            Survey part;
            part.add(**chunk);
            if (!isFound && hasDominantLight(**chunk, options)) isFound = true;
            return part;
        },
        [&](const Survey& part) { survey.merge(part); });
    if (!surveyed) return tl::make_unexpected(surveyed.error());
    hasDominant = isFound;
    return survey;
}

/// Measures the errors without the bands above orders 0 and 1. One over the limit stays empty.
Result<void> measureOrders(LightMapSource& source, const Survey& survey, const LightMapContentParameters& parameters,
                           LightMapContent& content, const ActionContext& context) {
    std::optional<verify::LightMapScore> score;
    for (const int order : {0, 1}) {
        std::optional<double>& result = order == 0 ? content.errorOfOrder0 : content.errorOfOrder1;
        if (survey.errorOf(order) == 0) {  // bakes of lower order, which have nothing to leave out
            result = 0;
            continue;
        }
        // The estimate is of all normals. Those that are shaded see more of the light, so the error is at most about this.
        if (survey.errorOf(order) > 2 * parameters.maxError) continue;
        if (!score) {
            LC_TRY(created, scoreOf(source, parameters, context));
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
    fit::DominantLightOptions light{.luminanceWeights = source.luminanceWeights()};
    if (parameters->dominantFit) {
        LC_TRY(fit, dominantFitOf(context.action.asset, *parameters->dominantFit));
        light.fit = (*fit)->cooked;
    }
    bool hasDominant = !parameters->dominantFit;
    LC_TRY(survey, surveyContent(source, light, hasDominant, context));
    LightMapContent content;
    content.width = source.width();
    content.height = source.height();
    content.covered = survey->light.texels();
    content.isConstant = survey->light.isConstant() && (survey->light.hasOneNormal() || survey->light.isIsotropic());
    content.isBlack = survey->light.isBlack();
    content.hasOneNormal = survey->light.hasOneNormal();
    content.hasDominant = hasDominant;
    LC_CHECK(measureOrders(source, *survey, *parameters, content, context));
    return outcomeWith(content);
}

}  // namespace lightcook::pipeline
