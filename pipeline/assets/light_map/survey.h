// Measurements of a light map before it is cooked or verified.
#pragma once

#include <functional>
#include <memory>

#include "compress/light_map.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/graph/action.h"
#include "verify/light_map.h"

namespace lightcook::pipeline {

/// Chunk `index` of a light map.
using ChunkFunction = std::function<formats::Result<std::shared_ptr<const formats::LightMapStrip>>(int index)>;

/// Returns a key of none of a bake's texels.
verify::LightMapKey emptyKeyOf(const LightMapSource& bake);
/// Returns the luminances of a bake's exit radiance: the key of every error figure, and that which a display is exposed for.
formats::Result<verify::LightMapKey> surveyKey(LightMapSource& bake, const ActionContext& context);
/// The same of chunks that are not those of the bake itself.
formats::Result<verify::LightMapKey> surveyKey(const LightMapSource& bake, const ChunkFunction& chunkOf, const ActionContext& context);

struct MeasuredLightMap {
    compress::LightMapMeasure measure;
    verify::LightMapKey key;
    formats::LightMapRepairs repairs;
    std::int64_t negativeAfterGamut = 0;
};
/// Measures the ranges that an encoder needs, and counts repaired texels.
/// hasSharedExit  true if a layout needs it (compress::needsSharedExit)
formats::Result<MeasuredLightMap> measureLightMap(LightMapSource& source, bool hasSharedExit, const ActionContext& context);

}  // namespace lightcook::pipeline
