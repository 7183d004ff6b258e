// The state of a LightMapVerifier. Private to verify/.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "verify/light_map.h"
#include "verify/light_map/bound_evaluator.h"
#include "verify/light_map/layouts.h"
#include "verify/light_map/map_decoder.h"
#include "verify/light_map/shading.h"
#include "verify/light_map/verified_rows.h"

namespace lightcook::verify {

struct LightMapVerifier::State {
    CookedLightMap map;
    LightMapShading shading;
    LightMapSampling sampling;
    float perKey = 1;  ///< light in units of the key
    layouts::Layout layout;
    std::optional<layouts::Layout> detail;                ///< of CookedLightMap::detail
    std::shared_ptr<const lightmap::MapDecoder> decoder;  ///< of layout
    std::vector<TextureNeed> textures;
    ShadingSetup setup;

    /// Returns the decoder of the texels of a strip, which outlives it. A layout in tangent space needs its tangents.
    std::shared_ptr<const lightmap::MapDecoder> decoderOn(const formats::LightMapStrip& strip) const {
        return layouts::infoOf(layout).isInTangentSpace ? lightmap::tangentDecoder(layout, perKey, strip) : decoder;
    }
    lightmap::RowInputs inputs(const DecodedLightMapRows& texels, const formats::LightMapStrip& reference) const {
        return {decoderOn(reference), map, sampling, setup, texels, reference};
    }
};

}  // namespace lightcook::verify
