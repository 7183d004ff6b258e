#include "pipeline/assets/light_map/survey.h"

#include "pipeline/graph/parallel_for.h"
#include "verify/light_map.h"

namespace lightcook::pipeline {

using formats::Result;

namespace {

MeasuredLightMap emptyMeasure(const LightMapSource& source, bool hasSharedExit) {
    return {compress::LightMapMeasure(source.luminanceWeights(), hasSharedExit), emptyKeyOf(source), {}, 0};
}

}  // namespace

verify::LightMapKey emptyKeyOf(const LightMapSource& bake) {
    return verify::LightMapKey(bake.luminanceWeights(), bake.hasCoverage());
}

Result<verify::LightMapKey> surveyKey(LightMapSource& bake, const ActionContext& context) {
    return surveyKey(
        bake, [&](int index) { return bake.chunk(index); }, context);
}

Result<verify::LightMapKey> surveyKey(const LightMapSource& bake, const ChunkFunction& chunkOf, const ActionContext& context) {
    using verify::LightMapKey;
    const auto parts =
        mapInOrder<LightMapKey>(bake.chunkCount(), context, "survey " + context.action.asset, [&](int index) -> Result<LightMapKey> {
            LC_TRY(chunk, chunkOf(index));
            LightMapKey part = emptyKeyOf(bake);
            part.add(**chunk, (*chunk)->firstRow, bake.chunkRows(index));
            return part;
        });
    if (!parts) return tl::make_unexpected(parts.error());
    LightMapKey key = emptyKeyOf(bake);
    for (const LightMapKey& part : *parts) key.merge(part);
    return key;
}

Result<MeasuredLightMap> measureLightMap(LightMapSource& source, bool hasSharedExit, const ActionContext& context) {
    auto parts = mapInOrder<MeasuredLightMap>(source.chunkCount(), context, "measure " + context.action.asset,
                                              [&](int index) -> Result<MeasuredLightMap> {
                                                  LC_TRY(chunk, source.chunk(index));
                                                  MeasuredLightMap part = emptyMeasure(source, hasSharedExit);
                                                  part.repairs = (*chunk)->repairs;
                                                  part.negativeAfterGamut = (*chunk)->negativeAfterGamut;
                                                  part.measure.add(**chunk);
                                                  part.key.add(**chunk, (*chunk)->firstRow, source.chunkRows(index));
                                                  return part;
                                              });
    if (!parts) return tl::make_unexpected(parts.error());
    MeasuredLightMap whole = emptyMeasure(source, hasSharedExit);
    for (const MeasuredLightMap& part : *parts) {
        whole.measure.merge(part.measure);
        whole.key.merge(part.key);
        whole.repairs += part.repairs;
        whole.negativeAfterGamut += part.negativeAfterGamut;
    }
    return whole;
}

}  // namespace lightcook::pipeline
