// cook --preview: a scene as fast as its light can be seen. Blocks are encoded with effort 0, no layout is tried, nothing is held to a
// limit, and of each light map some rows alone are compared with the bake. There is no report: the manifest says that it is a preview,
// and `verify` refuses it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "formats/error.h"
#include "pipeline/assets/light_map/sampled.h"
#include "pipeline/cook/plan.h"
#include "pipeline/document/json_fields.h"
#include "pipeline/graph/executor.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

/// A light map of a preview.
struct PreviewedMap {
    std::string name, layout;
    SampledErrors errors;
};
template <class Fields, Is<PreviewedMap> Self>
void describe(Fields& fields, Self& map) {
    fields.required("name", map.name, "name of the light map");
    fields.required("layout", map.layout, "layout");
    describe(fields, map.errors);
}

/// What a preview says in place of a report.
struct PreviewSummary {
    bool isPreview = true;
    std::string scene;
    double seconds = 0;
    std::uint64_t bytesGpu = 0;
    std::vector<PreviewedMap> lightMaps = {};
};
template <class Fields, Is<PreviewSummary> Self>
void describe(Fields& fields, Self& summary) {
    fields.required("preview", summary.isPreview, "true: nothing is verified or bounded");
    fields.required("scene", summary.scene, "name of the scene");
    fields.required("seconds", summary.seconds, kFigure, "wall time");
    fields.required("bytes_gpu", summary.bytesGpu, "GPU memory of all assets [bytes]");
    fields.required("light_maps", summary.lightMaps, "light maps, with the errors of some rows");
}

/// Returns a scene as its preview is cooked: with effort 0 and without limits.
Scene previewOf(Scene scene);

/// Returns the decisions of the last cook or preview of a scene into a folder, without layouts that the scene does not allow any more. A
/// preview takes them over.
Decisions decisionsIn(const std::filesystem::path& folder, const Scene& scene);

/// Returns the layout of a preview of a light map whose layout is open: the fastest that may be taken.
std::string previewLayoutOf(const Scene& scene, const LightMapEntry& entry);

/// Returns the actions of a plan that cook assets, and those that compare light maps in place of their verification.
std::vector<Action> previewActionsOf(const Plan& plan);

/// Returns the summary of a preview.
formats::Result<PreviewSummary> previewSummary(const Scene& scene, const Plan& plan, const ExecutionResult& result, double seconds);

}  // namespace lightcook::pipeline
