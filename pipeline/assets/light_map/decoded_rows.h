// Rows of a light map, encoded and decoded without files.
#pragma once

#include "compress/light_map.h"
#include "formats/error.h"
#include "formats/light_map.h"
#include "pipeline/assets/light_map/kept_plan.h"
#include "pipeline/assets/light_map/source.h"
#include "verify/light_map.h"

namespace lightcook::pipeline {

/// Returns a plan as the verifier sees it, and as a layout without its last layers would be.
verify::CookedLightMap cookedMapOf(const compress::LightMapPlan& plan, const formats::LightMapLayoutInfo& layout);
inline verify::CookedLightMap cookedMapOf(const compress::LightMapPlan& plan) {
    return cookedMapOf(plan, formats::info(plan.layout));
}

/// Rows of a bake, and what a plan makes of them.
struct PlannedRows {
    formats::LightMapStrip texels;        ///< with what the encoder needs beside these rows
    verify::DecodedLightMapRows decoded;  ///< by the verifier's own decoders
};
/// Encodes and decodes rows [firstRow, endRow): whole rows of the plan's blocks, except at the map's end.
formats::Result<PlannedRows> planRows(LightMapSource& source, const compress::LightMapPlan& plan, const compress::EncodeOptions& options,
                                      int firstRow, int endRow);
/// Does the same with a strip, which the encoder may have in the cache, and the blocks below it.
formats::Result<PlannedRows> planStrip(LightMapSource& source, const StripEncoder& encoder, int index);

}  // namespace lightcook::pipeline
