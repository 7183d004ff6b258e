// The bake that a repacked one was made of, as parameters of the verifications of its assets. The manifest has them as `verify.unpacked`.
#pragma once

#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "pipeline/assets/light_map/source.h"
#include "pipeline/document/json_fields.h"

namespace lightcook::pipeline {

/// Record of the packing of a light map's charts (pipeline/repack/repack.h).
struct ChartPacking {
    double maxVisible = 0;                  ///< of fewer texels; 0: charts were moved only
    int widthBefore = 0, heightBefore = 0;  ///< [texels]
    int width = 0, height = 0;              ///< [texels]
    std::int64_t readBefore = 0, read = 0;  ///< texels that filters read
    std::int64_t charts = 0, reducedCharts = 0;
    double relRms = 0, visible = 0;  ///< of the repacked bake against the bake; the 99th percentile
    std::string uvBefore;            ///< vertex attribute of the cooked mesh with the UVs that it had
};
template <class Fields, Is<ChartPacking> Self>
void describe(Fields& fields, Self& packing) {
    constexpr FieldRule kSide = between(1, kLargestSide), kCount = between(0, kLargestBytes), kNotNegative = between(0, HUGE_VAL);
    fields.required("max_visible", packing.maxVisible, kNotNegative, "visible error that fewer texels may add; 0: charts were moved only");
    fields.required("width_before", packing.widthBefore, kSide, "width of the bake [texels]");
    fields.required("height_before", packing.heightBefore, kSide, "height of the bake [texels]");
    fields.required("width", packing.width, kSide, "width of the repacked bake [texels]");
    fields.required("height", packing.height, kSide, "height of the repacked bake [texels]");
    fields.required("texels_read_before", packing.readBefore, kCount, "texels of the bake that filters read");
    fields.required("texels_read", packing.read, kCount, "texels of the repacked bake that filters read");
    fields.required("charts", packing.charts, kCount, "number of charts");
    fields.required("reduced_charts", packing.reducedCharts, kCount, "number of charts with fewer texels");
    fields.required("rel_rms", packing.relRms, kNotNegative, "`rel_rms` of exit radiance of the repacked bake, against the bake");
    fields.required("visible_p99", packing.visible, kNotNegative, "99th percentile of its visible error");
    fields.required("uv_before", packing.uvBefore, "vertex attribute of the cooked mesh with the light-map UVs that it had: `TEXCOORD_2`");
}

struct UnpackedBake {
    formats::LightMapDescription description;
    ChartPacking packing;
    std::vector<int> places;  ///< of each chart of the map: step in x and y, first texel's x and y (ChartPlace)
};
template <class Fields, Is<UnpackedBake> Self>
void describe(Fields& fields, Self& bake) {
    fields.required("description", bake.description, "conventions of the bake");
    fields.required("packing", bake.packing, "how its charts were packed");
    fields.required("places", bake.places, "of each chart: texels of the bake for each texel in x and y, and x and y of its first texel");
}

/// The parameter of a verification, beside those of the asset's kind. Absent: no charts were packed.
struct UnpackedParameter {
    std::optional<UnpackedBake> unpacked;
};
inline constexpr const char* kUnpackedKey = "unpacked";
template <class Fields, Is<UnpackedParameter> Self>
void describe(Fields& fields, Self& parameter) {
    fields.optional(kUnpackedKey, parameter.unpacked, "the bake of a map whose charts were packed, which it is judged against");
}

/// Returns the bake that the sources of an asset were repacked from, as the manifest has it. Empty: they are the user's own.
inline formats::Result<std::optional<UnpackedBake>> unpackedBakeOf(const CookedAsset& asset) {
    LC_TRY(parameter, fromJson<UnpackedParameter>(asset.verify.value_or(Json::object()), asset.name + ", verify"));
    return std::move(parameter->unpacked);
}

/// Inputs of a light map's verification: the bake and the mesh as they were. Files beside the bake have the role of bakeInputs() with this
/// in place of "source".
inline constexpr const char* kUnpackedRole = "unpacked";
inline constexpr const char* kUnpackedMeshRole = "unpacked_mesh";

/// Stage of a repacked map with the figures against the repacked bake; "total" is against the bake.
inline constexpr const char* kRepackedStage = "repacked";

}  // namespace lightcook::pipeline
