#include "pipeline/assets/light_map/survey.h"

#include <glm/geometric.hpp>

#include "lighting/sh.h"
#include "pipeline/assets/light_map/part_of_chunk.h"
#include "pipeline/graph/parallel_for.h"

namespace lightcook::pipeline {

using formats::Result;
using verify::LightMapKey;

namespace {

LightMapKey emptyKeyOf(const LightMapSource& bake) {
    return LightMapKey(bake.luminanceWeights(), bake.hasCoverage());
}

}  // namespace

MapSurvey::MapSurvey(const LightMapSource& source, bool hasSharedExit)
    : key(emptyKeyOf(source)), measure(source.luminanceWeights(), hasSharedExit), hasSharedExit_(hasSharedExit) {}

void MapSurvey::add(const formats::LightMapStrip& strip) {
    key.add(strip, strip.firstRow, strip.sh.height());
    measure.add(strip);
    light.add(strip);
    repairs += strip.repairs;
    negativeAfterGamut += strip.negativeAfterGamut;
    for (int y = 0; y < strip.sh.height(); ++y)
        for (int x = 0; x < strip.sh.width(); ++x) {
            if (strip.covered.at(x, y) == 0) continue;
            const lighting::ShRgb& sh = strip.sh.at(x, y);
            for (std::size_t i = 0; i < sh.size(); ++i)
                energy[static_cast<std::size_t>(lighting::kShBand[i])] += glm::dot(glm::dvec3(sh[i]), glm::dvec3(sh[i]));
        }
}

void MapSurvey::merge(const MapSurvey& next) {
    key.merge(next.key);
    measure.merge(next.measure);
    light.merge(next.light);
    repairs += next.repairs;
    negativeAfterGamut += next.negativeAfterGamut;
    for (std::size_t band = 0; band < energy.size(); ++band) energy[band] += next.energy[band];
}

Result<MapSurvey> surveyMap(LightMapSource& source, bool hasSharedExit, const ActionContext& context) {
    MapSurvey whole(source, hasSharedExit);
    LC_CHECK(foldInOrder<MapSurvey>(
        source.chunkCount(), context, "survey " + context.action.asset,
        [&](int index) {
            return partOfChunk(source, index, context, digestOf("survey", source.luminanceWeights(), source.hasCoverage(), hasSharedExit),
                               [&](const formats::LightMapStrip& chunk) -> Result<MapSurvey> {
                                   MapSurvey part(source, hasSharedExit);
                                   part.add(chunk);
                                   return part;
                               });
        },
        [&](const MapSurvey& part) { whole.merge(part); }));
    return whole;
}

Result<LightMapKey> surveyKey(const LightMapSource& bake, const ChunkFunction& chunkOf, const ActionContext& context) {
    LightMapKey key = emptyKeyOf(bake);
    LC_CHECK(foldInOrder<LightMapKey>(
        bake.chunkCount(), context, "survey " + context.action.asset,
        [&](int index) -> Result<LightMapKey> {
            LC_TRY(chunk, chunkOf(index));
            LightMapKey part = emptyKeyOf(bake);
            part.add(**chunk, (*chunk)->firstRow, (*chunk)->sh.height());
            return part;
        },
        [&](const LightMapKey& part) { key.merge(part); }));
    return key;
}

}  // namespace lightcook::pipeline
