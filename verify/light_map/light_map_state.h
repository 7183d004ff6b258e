// The state of a LightMapVerifier. Private to verify/.
#pragma once

#include <vector>

#include "verify/light_map.h"
#include "verify/light_map/bound_evaluator.h"
#include "verify/light_map/layouts.h"
#include "verify/light_map/shading.h"
#include "verify/light_map/verified_rows.h"

namespace lightcook::verify {

struct LightMapVerifier::State {
    CookedLightMap map;
    LightMapShading shading;
    LightMapSampling sampling;
    float perKey = 1;  ///< light in units of the key
    layouts::Layout layout;
    std::vector<TextureNeed> textures;
    ShadingSetup setup;

    lightmap::RowInputs inputs(const DecodedLightMapRows& texels, const formats::LightMapStrip& reference) const {
        return {map, sampling, setup, perKey, texels, reference};
    }
};

}  // namespace lightcook::verify
