// Verification of some rows of a map. Private to verify/.
#pragma once

#include <memory>

#include "verify/light_map.h"
#include "verify/light_map/bound_evaluator.h"
#include "verify/light_map/map_decoder.h"

namespace lightcook::verify::lightmap {

/// Inputs of the verification of some rows.
struct RowInputs {
    std::shared_ptr<const MapDecoder> decoder;
    const CookedLightMap& map;
    const LightMapSampling& sampling;
    const ShadingSetup& setup;
    const DecodedLightMapRows& texels;
    const formats::LightMapStrip& reference;
};

/// Verifies rows [firstRow, firstRow + rowCount), as LightMapVerifier::verifyRows.
/// errors  empty, with one stage for each of the layout's
LightMapErrors verifyRows(LightMapErrors errors, const RowInputs& inputs, int firstRow, int rowCount);

/// Bounds the quad whose top left texel is (x, y), as LightMapVerifier::boundQuad.
LightMapVerifier::QuadBound boundQuad(LightMapErrors errors, const RowInputs& inputs, int x, int y);

/// Bounds the visible errors of an area, as LightMapVerifier::visibleBound.
LightMapVerifier::AreaVisibleBound visibleBound(LightMapErrors errors, const RowInputs& inputs, const TexelArea& area);

}  // namespace lightcook::verify::lightmap
