// A FrontierPoint is an allocation of a scene's GPU memory that no other beats in bytes and visible error. report.json lists them, so that
// a reader sees what each budget would buy. pipeline/cook/allocation.h says how they are found.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/assets/cooked_asset.h"
#include "pipeline/document/json_fields.h"
#include "pipeline/report/report_row.h"

namespace lightcook::pipeline {

/// Layout of a light map.
struct AllocatedLayout {
    std::string lightMap, layout;
};
template <class Fields, Is<AllocatedLayout> Self>
void describe(Fields& fields, Self& layouts) {
    fields.required("light_map", layouts.lightMap, "name of the light map");
    fields.required("layout", layouts.layout, "its layout");
}

/// A scene under one allocation.
struct FrontierPoint {
    std::uint64_t bytesGpu = 0;
    double visible = 0;
    bool isChosen = false;
    std::vector<AllocatedLayout> layouts;
};
template <class Fields, Is<FrontierPoint> Self>
void describe(Fields& fields, Self& point) {
    fields.required("bytes_gpu", point.bytesGpu, between(0, kLargestBytes),
                    "GPU memory of the whole scene, with the specular tables of this cook");
    fields.required(
        "visible", point.visible, between(0, HUGE_VAL),
        "99th percentile of the visible errors of the whole shading, of the worst light map: verified, or as its trial measured it, times "
        "how much more the verified layouts had than their trials");
    fields.required("chosen", point.isChosen, "true for the allocation of this cook, whose bytes and error are those of the cooked files");
    fields.required("layouts", point.layouts, "what each light map gets");
}

/// Returns the points with the bytes and the error that the chosen one has in the rows of its cook, and without those that it beats then:
/// trials estimate both. As they are if the rows do not have the error.
std::vector<FrontierPoint> asCooked(std::vector<FrontierPoint> points, const std::vector<ReportRow>& rows);

/// Returns "lightmap: basis-4; ...".
std::string layoutWords(const FrontierPoint& point);

}  // namespace lightcook::pipeline
