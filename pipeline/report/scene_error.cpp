#include "pipeline/report/scene_error.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "pipeline/assets/light_map/unpacked_bake.h"
#include "pipeline/assets/lut/light_moments.h"
#include "pipeline/report/advice.h"
#include "pipeline/report/words.h"

namespace lightcook::pipeline {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
/// The verifier writes the largest double for a figure that exceeds every limit; sums must not use it.
constexpr double kNoFigure = 1e300;

enum Light { kDiffuse, kArea, kAnalytic, kEnvironment };
using Lights = std::array<double, kLightNames.size()>;

double square(double value) {
    return value * value;
}

/// Returns NaN for a figure that is not finite, or that stands for none.
double figure(double value) {
    return std::isfinite(value) && value < kNoFigure ? value : kNan;
}

/// Selects the figures of one kind of shading.
using Figures = verify::ErrorFigures verify::StageError::*;
constexpr Figures kDiffuseFigures = &verify::StageError::diffuse, kSpecularFigures = &verify::StageError::specular;

double relRmsOf(const ReportRow& row, Figures figures) {
    return figure((row.verdict.stages.back().*figures).relRms);
}

/// Returns a figure of the row's light; NaN without it.
double lightOf(const ReportRow& row, std::optional<double> LightFigures::*member) {
    return row.light ? figure((*row.light.*member).value_or(kNan)) : kNan;
}

/// Returns error / light: 0 for no error without light, infinity for an error without light.
double relative(double squaredError, double squaredLight) {
    return squaredError == 0 ? 0 * squaredLight : std::sqrt(squaredError / squaredLight);
}

Moments momentsOf(const ReportRow& row, std::optional<std::vector<double>> LightFigures::*member) {
    Moments moments;
    moments.fill(kNan);
    const auto& list = *row.light.*member;
    if (list && list->size() == moments.size())
        for (std::size_t i = 0; i < moments.size(); ++i)
            if (std::isfinite((*list)[i])) moments[i] = (*list)[i];
    return moments;
}
/// Returns the rel_rms of the light that the tables reflect of a light map.
double tablesRelRms(const ReportRow& tables, const ReportRow& map) {
    const Moments light = momentsOf(map, &LightFigures::moments);
    return relative(meanSquare(momentsOf(tables, &LightFigures::errorMoments), light),
                    meanSquare(momentsOf(tables, &LightFigures::kernelMoments), light));
}

/// One asset in one kind of shading. Members are squares, so that averages over light maps are sums.
struct Part {
    const ReportRow* row;
    Figures figures;
    const char* name;  ///< of the shading, as reported
    double squaredError = 0, squaredLight = 0;
    bool isAlternative = false;  ///< a pixel has the error of only one of the alternatives
};

/// All light that the pixels of one light map, or of all light maps, show.
struct Shading {
    Lights squaredLights{};
    std::vector<Part> parts;
    double squaredBound = 0;

    double squaredLight() const {
        double sum = 0;
        for (const double light : squaredLights) sum += light;
        return sum;
    }
    double squaredError() const {
        double sum = 0;
        for (const Part& part : parts) sum += part.squaredError;
        return sum;
    }
    /// Sets the upper bound: errors of one pixel add up at worst; of alternatives it has only one.
    void bound() {
        double sum = 0, alternatives = 0;
        for (const Part& part : parts) {
            if (part.isAlternative)
                alternatives += part.squaredError;
            else
                sum += std::sqrt(part.squaredError);
        }
        squaredBound = square(sum + std::sqrt(alternatives));
    }
    /// Adds the light of a part of all pixels, weighted by its share.
    void add(const Shading& other, double weight) {
        for (std::size_t i = 0; i < squaredLights.size(); ++i) squaredLights[i] += weight * other.squaredLights[i];
        squaredBound += weight * other.squaredBound;
        for (const Part& part : other.parts) {
            auto mine =
                std::ranges::find_if(parts, [&](const Part& each) { return each.row == part.row && std::string(each.name) == part.name; });
            if (mine == parts.end()) {
                parts.push_back({part.row, part.figures, part.name, 0, 0, part.isAlternative});
                mine = parts.end() - 1;
            }
            mine->squaredError += weight * part.squaredError;
            mine->squaredLight += weight * part.squaredLight;
        }
    }
};

class Whole {
public:
    explicit Whole(const std::vector<ReportRow>& rows) : rows_(rows) {
        for (const ReportRow& row : rows) {
            if (!row.light) continue;
            if (row.kind == AssetKind::LightMap) lightMaps_.push_back(&row);
            if (row.kind == AssetKind::Lut) tables_.push_back(&row);
            if (row.kind == AssetKind::Cubemap) probes_.push_back(&row);
        }
        for (const ReportRow* probe : probes_) {
            const double count = static_cast<double>(probes_.size());
            if (probe->light->specularRms)
                squaredPlain_ += square(lightOf(*probe, &LightFigures::specularRms)) / count;
            else
                squaredRatio_ += square(lightOf(*probe, &LightFigures::ratioRms)) / count;
        }
    }

    std::optional<SceneError> error() const {
        if (lightMaps_.empty()) return {};
        std::vector<Shading> shadings;
        double texels = 0;
        for (const ReportRow* map : lightMaps_) {
            shadings.push_back(shadingOf(*map));
            texels += lightOf(*map, &LightFigures::texels);
        }
        Shading scene;
        SceneError whole;
        for (std::size_t i = 0; i < lightMaps_.size(); ++i) {
            // A map without covered texels shows nothing; if no map has any, all weigh the same.
            const double weight =
                texels > 0 ? lightOf(*lightMaps_[i], &LightFigures::texels) / texels : 1 / static_cast<double>(lightMaps_.size());
            scene.add(shadings[i], weight);
            if (lightMaps_.size() > 1) whole.lightMaps.push_back({lightMaps_[i]->name, weight, errorOf(shadings[i])});
        }
        whole.shading = errorOf(scene);
        whole.apart = apart(scene);
        return whole;
    }

private:
    Shading shadingOf(const ReportRow& map) const {
        Shading shading;
        const auto add = [&](const ReportRow& row, Figures figures, const char* name, double relRms, double light,
                             bool isAlternative = false) {
            shading.parts.push_back({&row, figures, name, square(relRms * light), square(light), isAlternative});
        };
        const double diffuse = lightOf(map, &LightFigures::diffuseRms), specular = lightOf(map, &LightFigures::specularRms);
        shading.squaredLights[kDiffuse] = square(diffuse);
        add(map, kDiffuseFigures, "diffuse", relRmsOf(map, kDiffuseFigures), diffuse);
        for (const ReportRow& row : rows_) {
            const bool isDominant = row.kind == AssetKind::Dominant;
            if ((!isDominant && row.kind != AssetKind::Mesh) || !row.light || lightMapOf(row, lightMaps_) != &map) continue;
            const double light = lightOf(row, isDominant ? &LightFigures::specularRms : &LightFigures::diffuseRms);
            const Figures figures = isDominant ? kSpecularFigures : kDiffuseFigures;
            if (isDominant) shading.squaredLights[kAnalytic] += square(light);
            add(row, figures, isDominant ? "analytic specular" : "diffuse", relRmsOf(row, figures), light);
        }
        // A cubemap that is not divided is seen as it is, whatever the area specular of the pixel: also where the map is black.
        shading.squaredLights[kEnvironment] = squaredPlain_;
        if (specular != 0) {
            shading.squaredLights[kArea] = square(specular);
            shading.squaredLights[kEnvironment] += squaredRatio_ * square(specular);
            // An error of S is visible twice: directly, and in the environment's light R S.
            const double reflected = specular * (1 + std::sqrt(squaredRatio_));
            add(map, kSpecularFigures, "area specular", relRmsOf(map, kSpecularFigures), reflected);
            for (const ReportRow* tables : tables_) add(*tables, kSpecularFigures, "area specular", tablesRelRms(*tables, map), reflected);
        }
        for (const ReportRow* probe : probes_) {
            const bool isPlain = probe->light->specularRms.has_value();
            if (!isPlain && specular == 0) continue;
            const double relRms = isPlain ? relRmsOf(*probe, kSpecularFigures) : lightOf(*probe, &LightFigures::ratioRelRms);
            const double light =
                isPlain ? lightOf(*probe, &LightFigures::specularRms) : specular * lightOf(*probe, &LightFigures::ratioRms);
            add(*probe, kSpecularFigures, "environment", relRms, light / std::sqrt(static_cast<double>(probes_.size())), true);
        }
        shading.bound();
        return shading;
    }

    /// Returns the share of each stage if it were alone, in proportion to its own rel_rms.
    static std::vector<StageShare> stagesOf(const Part& part, double share) {
        std::vector<StageShare> shares;
        const double total = relRmsOf(*part.row, part.figures);
        const auto& stages = part.row->verdict.stages;
        for (std::size_t i = 0; i + 1 < stages.size(); ++i) {
            if (stages[i].name == kRepackedStage) continue;  // the whole map, against another bake
            const double own = figure((stages[i].*part.figures).relRms);
            shares.push_back({stages[i].name, own == 0 ? 0 : share * square(own / total)});
        }
        return shares;
    }

    ShadingError errorOf(const Shading& shading) const {
        const double error = shading.squaredError(), light = shading.squaredLight();
        ShadingError result;
        result.relRms = relative(error, light);
        result.relRmsBound = relative(shading.squaredBound, light);
        result.lightRms = std::sqrt(light);
        for (std::size_t i = 0; i < result.lights.size(); ++i) result.lights[i] = std::sqrt(shading.squaredLights[i]);
        for (const Part& part : shading.parts) {
            const double share = error == 0 ? 0 : part.squaredError / error;
            result.parts.push_back({part.row->name, part.row->kind, part.name, share, relative(part.squaredError, part.squaredLight),
                                    std::sqrt(part.squaredLight), stagesOf(part, share)});
        }
        std::ranges::stable_sort(result.parts, std::ranges::greater{},
                                 [](const ErrorPart& part) { return std::isfinite(part.share) ? part.share : -1; });
        result.advice = adviceOf(result);
        return result;
    }

    /// Returns a sentence that names the part with the largest share, and one that says what lowers it, if that is known; or that there is
    /// no error, or no finite one.
    std::string adviceOf(const ShadingError& shading) const {
        if (!std::isfinite(shading.relRms) || shading.parts.empty() || !std::isfinite(shading.parts.front().share))
            return "A figure is not finite: there is no sum.";
        const ErrorPart& first = shading.parts.front();
        if (first.share == 0) return "There is no error.";
        const ReportRow& row = *std::ranges::find(rows_, first.asset, &ReportRow::name);
        const std::string remedy = remedyOf(row, std::nullopt, lightMapOf(row, lightMaps_));
        // Names of assets stand in quotation marks: one may be called "specular".
        return fmt::format("{} of the squared error ({}) comes from the {} '{}', in {} light.{}{}",
                           first.share > 0.5 ? "Most" : "The largest part", humanPercent(first.share), info(first.kind).shortCaption,
                           first.asset, first.shading, remedy.empty() ? "" : " ", remedy);
    }

    std::vector<ApartError> apart(const Shading& scene) const {
        std::vector<ApartError> errors;
        for (const ReportRow& row : rows_) {
            if (std::ranges::find(scene.parts, &row, &Part::row) != scene.parts.end()) continue;
            const double diffuse = relRmsOf(row, kDiffuseFigures), specular = relRmsOf(row, kSpecularFigures);
            const double worse = std::isnan(diffuse) || std::isnan(specular) ? kNan : std::max(diffuse, specular);
            errors.push_back({row.name, row.kind, worse});
        }
        return errors;
    }

    const std::vector<ReportRow>& rows_;
    std::vector<const ReportRow*> lightMaps_, tables_, probes_;
    double squaredRatio_ = 0;  ///< mean square of R over the cubemaps
    double squaredPlain_ = 0;  ///< the same of the light of those that are not divided
};

}  // namespace

std::optional<SceneError> sceneError(const std::vector<ReportRow>& rows) {
    return Whole(rows).error();
}

std::string lineOf(const SceneError& whole) {
    const ShadingError& shading = whole.shading;
    return fmt::format("whole shading: {} of its light (RMS), at most {}. {}", humanPercent(shading.relRms),
                       humanPercent(shading.relRmsBound), shading.advice);
}

}  // namespace lightcook::pipeline
