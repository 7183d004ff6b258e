#include "pipeline/assets/light_map/whole_errors.h"

#include <fmt/format.h>

#include <vector>

#include "pipeline/assets/dominant/cooked_dominant.h"
#include "pipeline/assets/light_map/cooked_light_map.h"
#include "pipeline/assets/light_map/kept_plan.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/assets/light_map/strip_digest.h"
#include "pipeline/assets/light_map/surface_places.h"
#include "pipeline/assets/light_map/survey.h"
#include "pipeline/graph/parallel_for.h"
#include "pipeline/graph/part_cache.h"
#include "pipeline/scene/dominant_fit.h"
#include "verify/whole_shading.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

/// A light map and its dominant light, beside their bake.
class WholeComparison {
public:
    /// dominant   null: it was left out, or is derived
    /// isDerived  the shader derives it from the light map
    /// fit        of the reference; empty: the reference has no dominant light
    WholeComparison(LightMapSource& bake, const CookedLightMapReader& lightMap, double key, const CookedDominantReader* dominant,
                    bool isDerived, const std::optional<verify::DominantFit>& fit, const verify::WholeShader& shader,
                    const verify::Viewing& viewing)
        : bake_(bake),
          lightMap_(lightMap),
          key_(key),
          dominant_(dominant),
          isDerived_(isDerived),
          fit_(fit),
          shader_(shader),
          viewing_(viewing),
          places_(bake.width(), bake.height()) {}

    /// Returns the errors of a strip. Those of a strip that an earlier cook has compared come from the cache.
    /// what  digest of all that the comparison was made with, beside the texels
    Result<verify::WholeErrors> errorsOf(int index, const PartCache* parts, const std::string& what) const {
        const int firstRow = bake_.stripFirstRow(index), rowCount = bake_.stripRows(index);
        return cachedPart(
            parts,
            [&]() -> Result<std::string> {
                LC_TRY(ofBake, bake_.digestOfStrip(index, 0, 1, *parts));
                LC_TRY(ofLightMap, lightMap_.digestOfRows(firstRow, rowCount + 1));
                std::string ofDominant;
                if (dominant_ != nullptr) {
                    LC_TRY(rows, dominant_->read(firstRow, rowCount));
                    ofDominant = digestOf(rows->whole.firstRow, digestOfImage(rows->whole.direction), digestOfImage(rows->whole.intensity));
                }
                return digestOf("whole", what, lightMap_.verifierDigest(), *ofBake, *ofLightMap, ofDominant);
            },
            [&] { return compare(index); });
    }

private:
    Result<verify::WholeErrors> compare(int index) const {
        LC_TRY(strip, readStrip(bake_, lightMap_, index));
        const std::vector<SurfacePlace> places = places_.of(strip->reference, strip->firstRow, strip->rowCount);
        const std::size_t count = 3 * shader_.stride(), all = places.size() * count;
        const std::vector<float> reference = shadeReference(shader_, places, fit_, bake_.luminanceWeights());
        std::vector<float> lightMap(all);
        LC_TRY(dominant, shadeStored(*strip, places));
        if (isDerived_) dominant->resize(all);
        std::vector<lighting::ShRgb> light(lightMap_.verifier().lightCount());
        for (std::size_t i = 0; i < places.size(); ++i) {
            if (!lightMap_.verifier().lightAt(strip->texels, strip->reference, places[i].at, light)) continue;
            for (glm::vec3& coefficient : light.back()) coefficient *= static_cast<float>(key_);
            shader_.shadeLightMap(light.back(), places[i].normal, std::span(lightMap).subspan(i * count, count));
            if (isDerived_)
                shader_.shadeDominant(verify::derivedLight(light.back(), places[i].normal), places[i].normal,
                                      std::span(*dominant).subspan(i * count, count));
        }
        return verify::wholeErrors(reference, lightMap, *dominant, shader_.sampleCount(), shader_.stride(), viewing_);
    }

    /// Returns what the stored dominant light adds; nothing without one.
    Result<std::vector<float>> shadeStored(const CookedStrip& strip, const std::vector<SurfacePlace>& places) const {
        std::vector<float> samples;
        if (dominant_ == nullptr) return samples;
        const std::size_t count = 3 * shader_.stride();
        samples.resize(places.size() * count);
        LC_TRY(rows, dominant_->read(strip.firstRow, strip.rowCount));
        const verify::DominantVerifier cooked(dominant_->map(), {}, bake_.luminanceWeights(), 0);
        for (std::size_t i = 0; i < places.size(); ++i)
            shader_.shadeDominant(cooked.decode(rows->whole, places[i].at.x, places[i].at.y), places[i].normal,
                                  std::span(samples).subspan(i * count, count));
        return samples;
    }

    LightMapSource& bake_;
    const CookedLightMapReader& lightMap_;
    double key_;
    const CookedDominantReader* dominant_;
    bool isDerived_;
    std::optional<verify::DominantFit> fit_;
    const verify::WholeShader& shader_;
    verify::Viewing viewing_;
    SurfacePlaces places_;
};

/// Opens the dominant light, unless it was left out.
Result<std::optional<CookedDominantReader>> openDominant(const ActionContext& context, const LightMapSource& bake) {
    if (context.upstream.size() < 2) return std::optional<CookedDominantReader>();
    LC_TRY(asset, upstreamAsset(context, 1));
    LC_TRY(reader, CookedDominantReader::open(context.upstreamFolder, *asset, {bake.width(), bake.height()}));
    return std::optional(std::move(*reader));
}

}  // namespace

std::vector<float> shadeReference(const verify::WholeShader& shader, std::span<const SurfacePlace> places,
                                  const std::optional<verify::DominantFit>& fit, const glm::vec3& luminanceWeights) {
    const std::size_t count = 3 * shader.stride();
    std::vector<float> samples(places.size() * count), light(count);
    verify::CookedDominant map;
    map.fit = fit.value_or(map.fit);
    const verify::DominantVerifier verifier(map, {}, luminanceWeights, 0);
    for (std::size_t i = 0; i < places.size(); ++i) {
        const SurfacePlace& place = places[i];
        const auto out = std::span(samples).subspan(i * count, count);
        shader.shadeLightMap(place.bake, place.normal, out);
        if (!fit) continue;
        const glm::dvec3 normal(place.normal);
        const verify::DominantLightSample towardsNormal{normal, glm::dvec3(0)};  // decides between equally good lights
        shader.shadeDominant(verifier.reference(place.bake, normal, towardsNormal), place.normal, light);
        for (std::size_t k = 0; k < count; ++k) out[k] += light[k];
    }
    return samples;
}

Result<ActionOutcome> verifyWhole(const ActionContext& context) {
    LC_TRY(parameters, parametersOf<WholeVerifyParameters>(context));
    LC_TRY(asset, upstreamAsset(context));
    LC_TRY(description, descriptionOf(*asset));
    LC_TRY(source, openLightMap(context, *description));
    LightMapSource& bake = **source;
    LC_TRY(survey, bake.survey(context));
    LC_TRY(keys, keysOf(context.action.asset, parameters->kept, (*survey)->key));
    std::optional<verify::DominantFit> fit;
    if (parameters->fit) {
        LC_TRY(named, dominantFitOf(context.action.asset, *parameters->fit));
        fit = (*named)->verified;
    }
    verify::LightMapSampling sampling;
    sampling.placesPerTexel = 0;
    sampling.figures = verify::LightMapFigures::Sampled;
    LC_TRY(lightMap, CookedLightMapReader::open(context.upstreamFolder, *asset, {parameters->view.shading, sampling, keys->key}));
    LC_TRY(dominant, openDominant(context, bake));
    LC_TRY(shader, verify::WholeShader::create(parameters->view.shading));
    const verify::Viewing viewing{parameters->view.display.of(keys->displayKey), bake.bt2020FromWorking()};
    const WholeComparison comparison(bake, *lightMap, keys->key, *dominant ? &**dominant : nullptr, parameters->isDerived, fit, *shader,
                                     viewing);
    const verify::CookedDominant decode = *dominant ? (*dominant)->map() : verify::CookedDominant();
    const WholeVerifyParameters shaded{parameters->view, parameters->fit, parameters->isDerived};  // limits and kept keys judge alone
    const std::string what = digestOf(toJson(shaded).dump(), viewing, bake.luminanceWeights(), (*dominant).has_value(),
                                      decode.directionScale, decode.directionBias, decode.intensityRange);
    verify::WholeErrors errors;
    LC_CHECK(foldInOrder<verify::WholeErrors>(
        bake.stripCount(), context, fmt::format("verify the whole of {}", context.action.asset),
        [&](int index) { return comparison.errorsOf(index, context.parts, what); },
        [&](const verify::WholeErrors& strip) { errors.append(strip); }));
    return outcomeWith(
        WholeFigures{errors.visibleFigures(), errors.relRms(), static_cast<int>(errors.squaredErrors.size()), parameters->limits});
}

}  // namespace lightcook::pipeline
