// Verification of rows, one instance for each layout. Private to verify/.
//
// The instances are compiled in several sources (rows_*.cpp), because one source with all of them takes two minutes. A layout without an
// instance does not link: add it to the source of its kind.
#pragma once

#include "verify/light_map.h"
#include "verify/light_map/bound_evaluator.h"

namespace lightcook::verify::lightmap {

/// Inputs of the verification of some rows, beside the layout.
struct RowInputs {
    const CookedLightMap& map;
    const LightMapSampling& sampling;
    const ShadingSetup& setup;
    float perKey = 1;  ///< 1 / key: converts light to units of the key
    const DecodedLightMapRows& texels;
    const formats::LightMapStrip& reference;
};

/// Verifies rows [firstRow, firstRow + rowCount), as LightMapVerifier::verifyRows.
/// errors  empty, with one stage for each of the layout's
template <class Layout>
LightMapErrors verifyRows(const Layout& layout, LightMapErrors errors, const RowInputs& inputs, int firstRow, int rowCount);

/// Bounds the quad whose top left texel is (x, y), as LightMapVerifier::boundQuad.
template <class Layout>
LightMapVerifier::QuadBound boundQuad(const Layout& layout, LightMapErrors errors, const RowInputs& inputs, int x, int y);

/// Bounds the visible errors of an area, as LightMapVerifier::visibleBound.
template <class Layout>
LightMapVerifier::AreaVisibleBound visibleBound(const Layout& layout, LightMapErrors errors, const RowInputs& inputs,
                                                const TexelArea& area);

}  // namespace lightcook::verify::lightmap
