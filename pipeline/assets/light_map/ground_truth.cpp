#include "pipeline/assets/light_map/ground_truth.h"

#include <fmt/format.h>

#include <algorithm>
#include <glm/geometric.hpp>
#include <tuple>

#include "fit/light_search.h"
#include "formats/color.h"
#include "pipeline/assets/light_map/checked_light_map.h"
#include "pipeline/assets/source_colors.h"
#include "pipeline/scene/dominant_layout.h"
#include "verify/whole_shading.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Result;
using formats::ShadingValue;
using verify::TruthErrors;
using verify::TruthSums;

Json splitOf(const TruthErrors& errors) {
    return {{"truncation", errors.model}, {"quantization", errors.cooking}, {"total", errors.total}};
}

Json dominantSplit(const TruthErrors& area, const TruthErrors& one, const TruthErrors& withRest, const TruthErrors& two) {
    return {{"truncation", area.model},    {"fit", one.model},       {"quantization", one.cooking}, {"total", one.total},
            {"with_rest", withRest.total}, {"two_lights", two.total}};
}

Json visibleSplit(const verify::TruthVisible& visible) {
    const auto figures = [](const verify::VisibleAccumulator& errors) {
        const verify::VisibleFigures found = errors.figures();
        return Json{{"rms", found.rms}, {"p50", found.p50},   {"p95", found.p95},
                    {"p99", found.p99}, {"p999", found.p999}, {"max", found.max}};
    };
    return {{"quantization", figures(visible.cooking)}, {"total", figures(visible.total)}};
}

}  // namespace

Result<GroundTruth> GroundTruth::open(const ActionContext& context, const LightMapSource& bake, const formats::ColorSpaces& colorSpaces) {
    GroundTruth truth;
    const auto file = context.action.inputs.find(kGroundTruthRole);
    if (file == context.action.inputs.end()) return truth;
    LC_TRY(values, formats::readShadingValues(file->second, bake.width(), bake.height()));
    LC_TRY(colors, formats::linearConversion(withConfig(colorSpaces, context.action)));
    if (!colors->isIdentity)
        for (ShadingValue& value : *values) value.value = glm::dmat3(colors->workingFromSource) * value.value;
    truth.file_ = file->second;
    truth.values_ = std::move(*values);
    std::ranges::stable_sort(truth.values_, {}, [](const ShadingValue& value) { return std::tuple(value.y, value.x); });
    return truth;
}

Result<std::span<const ShadingValue>> GroundTruth::within(const formats::LightMapStrip& strip, int firstRow, int rowCount) const {
    const auto first = std::ranges::lower_bound(values_, firstRow, {}, &ShadingValue::y);
    const auto last = std::ranges::lower_bound(values_, firstRow + rowCount, {}, &ShadingValue::y);
    for (auto value = first; value != last; ++value) {
        const int row = value->y - strip.firstRow;
        const auto refuse = [&](ErrorCode code, const std::string& detail) {
            return failure(code, formats::Subject(file_).at(fmt::format("line {}", value->line)), detail);
        };
        if (strip.covered.at(value->x, row) == 0)
            return refuse(ErrorCode::WrongShape,
                          fmt::format("found texel ({}, {}) outside every chart, expected one inside", value->x, value->y));
        if (value->kind != ShadingValue::Kind::Specular) continue;
        const glm::dvec3 normal(strip.normal.at(value->x, row));
        if (!(glm::dot(normal, value->direction) > 0))
            return refuse(ErrorCode::ValueOutOfRange,
                          fmt::format("found a view below the surface at texel ({}, {}), whose normal is ({:.3f}, {:.3f}, {:.3f}), "
                                      "expected one above it, in world space",
                                      value->x, value->y, normal.x, normal.y, normal.z));
    }
    return std::span(first, last);
}

std::vector<verify::LightMapTruthPlace> bakedPlaces(std::span<const ShadingValue> values, const formats::LightMapStrip& strip) {
    std::vector<verify::LightMapTruthPlace> places;
    for (const ShadingValue& value : values) {
        const int row = value.y - strip.firstRow;
        places.push_back({value, glm::dvec3(strip.normal.at(value.x, row)), strip.sh.at(value.x, row), {}});
    }
    return places;
}

std::vector<verify::LightMapTruthPlace> lightMapPlaces(std::span<const ShadingValue> values, const formats::LightMapStrip& strip,
                                                       const formats::Image<lighting::ShRgb>& cooked, int firstRow) {
    std::vector<verify::LightMapTruthPlace> places = bakedPlaces(values, strip);
    for (verify::LightMapTruthPlace& place : places) place.cooked = cooked.at(place.value.x, place.value.y - firstRow);
    return places;
}

std::vector<verify::DominantTruthPlace> dominantPlaces(std::span<const verify::LightMapTruthPlace> places,
                                                       const verify::DominantVerifier& verifier, bool hasAmbient,
                                                       const CookedLight& cookedLight) {
    std::vector<verify::DominantTruthPlace> lit;
    for (const verify::LightMapTruthPlace& each : places) {
        const ShadingValue& value = each.value;
        if (value.kind != ShadingValue::Kind::Specular) continue;
        // Values of one texel follow each other: its light is fitted once.
        if (!lit.empty() && lit.back().value.x == value.x && lit.back().value.y == value.y) {
            lit.push_back(lit.back());
            lit.back().value = value;
            continue;
        }
        verify::DominantTruthPlace place{value, each.normal, each.baked, {}, cookedLight(each), {}};
        place.fitted = verifier.reference(place.baked, place.normal, place.cooked);
        const fit::TwoLights two = fit::bestTwoLights(place.baked, glm::normalize(place.fitted.direction), hasAmbient);
        place.two = {verify::DominantLightSample{two.first.direction, two.first.intensity},
                     verify::DominantLightSample{two.second.direction, two.second.intensity}};
        lit.push_back(place);
    }
    return lit;
}

Json toJson(const verify::LightMapTruth& truth) {
    const TruthSums specular = sumOf(truth.areaSpecular);
    Json json = {{"values", truth.lambert.count() + specular.count()}};
    if (truth.lambert.count() > 0) json["lambert"] = splitOf(truth.lambert.errors());
    if (truth.visibleLambert.total.sampleCount() > 0) json["lambert"]["visible"] = visibleSplit(truth.visibleLambert);
    if (specular.count() == 0) return json;
    json["area_specular"] = splitOf(specular.errors());
    for (const auto& [m, sums] : truth.areaSpecular) {
        json["area_specular"]["by_m"].push_back(splitOf(sums.errors()));
        json["area_specular"]["by_m"].back()["m"] = m;
    }
    return json;
}

Json toJson(const verify::DominantTruth& truth) {
    const TruthErrors one = sumOf(truth.oneLight).errors(), two = sumOf(truth.twoLights).errors(),
                      area = sumOf(truth.areaSpecular).errors();
    Json specular = dominantSplit(area, one, sumOf(truth.withRest).errors(), two);
    for (const auto& [m, sums] : truth.oneLight) {
        specular["by_m"].push_back(
            dominantSplit(truth.areaSpecular.at(m).errors(), sums.errors(), truth.withRest.at(m).errors(), truth.twoLights.at(m).errors()));
        specular["by_m"].back()["m"] = m;
    }
    if (truth.visibleWithRest.total.sampleCount() > 0) specular["visible"] = visibleSplit(truth.visibleWithRest);
    return {{"values", sumOf(truth.oneLight).count()},
            {"specular", specular},
            {"fit_is_largest", one.model > area.model && one.model > one.cooking}};
}

Result<void> checkGroundTruth(CheckedLightMap& map) {
    const lighting::NormalDistribution lobe = map.parameters.shading.lobe;
    Json truth = toJson(verify::lightMapTruth(map.texels.shown.truthPlaces, lobe, map.viewing));
    if (map.asset.dominant == kDerivedDominant) {
        verify::CookedDominant light;
        light.fit = verify::DominantFit::Explained;
        const verify::DominantVerifier verifier(light, {}, map.bake.luminanceWeights(), 0);
        const std::vector<verify::DominantTruthPlace> places = dominantPlaces(
            map.texels.shown.truthPlaces, verifier, false,
            [](const verify::LightMapTruthPlace& place) { return verify::derivedLight(place.cooked, glm::vec3(place.normal)); });
        if (!places.empty()) {
            const Json specular = toJson(verify::dominantTruth(places, lobe, map.viewing));
            for (const char* each : {"specular", "fit_is_largest"}) truth[each] = specular.at(each);
        }
    }
    map.result.groundTruth = std::move(truth);
    return {};
}

}  // namespace lightcook::pipeline
