#include "pipeline/assets/light_map/sampled.h"

#include <vector>

#include "pipeline/assets/light_map/cooked_light_map.h"
#include "pipeline/assets/light_map/light_map.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/assets/light_map/survey.h"
#include "pipeline/assets/results.h"
#include "pipeline/graph/parallel_for.h"

namespace lightcook::pipeline {
namespace {

/// Texels that are compared, at most. Of larger maps they are one of kSampledPart rows of strips that are spread: 8 to 16 bands. The
/// visible error of as many bands of 16 rows lies within 0.6 to 1.3 times that of a public scene (docs/lab/pipeline.md).
constexpr std::int64_t kMostTexels = 1 << 16;
constexpr int kSampledPart = 8;

}  // namespace

formats::Result<ActionOutcome> sampleLightMap(const ActionContext& context) {
    LC_TRY(asset, upstreamAsset(context));
    LC_TRY(parameters, parametersOf<LightMapVerifyParameters>(context));
    LC_TRY(description, descriptionOf(*asset));
    LC_TRY(source, openLightMap(context, *description));
    LightMapSource& bake = **source;
    LC_TRY(survey, bake.survey(context.between(0, 0.5)));
    const verify::LightMapKey& key = (*survey)->key;
    verify::LightMapSampling sampling;
    sampling.placesPerTexel = parameters->samples;
    sampling.figures = verify::LightMapFigures::Sampled;
    const verify::Viewing viewing{parameters->display.of(key.displayKey()), bake.bt2020FromWorking()};
    LC_TRY(cooked, CookedLightMapReader::open(context.upstreamFolder, *asset, {parameters->shading, sampling, key.key(), viewing}));
    const int part = std::int64_t{bake.width()} * bake.height() <= kMostTexels ? 1 : kSampledPart;
    const std::vector<int> strips = spreadStrips(bake, part * kMostTexels);
    const auto rowsOf = [&](int strip) { return (bake.stripRows(strip) + part - 1) / part; };
    SampledErrors sampled{.total = {}, .rowsOfMap = bake.height()};
    for (const int strip : strips) sampled.rows += rowsOf(strip);
    verify::LightMapErrors errors = cooked->verifier().noErrors();
    LC_CHECK(foldInOrder<verify::LightMapErrors>(
        static_cast<int>(strips.size()), context.between(0.5, 1), "compare " + context.action.asset,
        [&](int index) -> formats::Result<verify::LightMapErrors> {
            const int strip = strips[static_cast<std::size_t>(index)], firstRow = bake.stripFirstRow(strip), rows = rowsOf(strip);
            LC_TRY(reference, bake.stripWithMargin(strip, 0, 1));
            LC_TRY(texels, cooked->read(firstRow, rows + 1));
            return cooked->verifier().verifyRows(*texels, *reference, firstRow, rows);
        },
        [&](const verify::LightMapErrors& each) { errors.merge(each); }));
    sampled.total = errors.figures().back();
    sampled.total.atTexels.reset();
    sampled.total.diffuse.maxBound.reset();  // nothing was bounded
    sampled.total.specular.maxBound.reset();
    return outcomeWith(sampled);
}

}  // namespace lightcook::pipeline
