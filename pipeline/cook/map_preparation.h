// The step of a cook between the materials and the plan: charts of light maps are packed anew. What comes after it takes the packed bakes
// and meshes as if the user had named them.
#pragma once

#include <filesystem>
#include <functional>
#include <vector>

#include "pipeline/cook/plan.h"
#include "pipeline/graph/executor.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

struct PreparedMaps {
    Scene scene;                ///< with repacked bakes and meshes; without light maps whose charts could not be packed
    std::vector<Action> graph;  ///< the packing of every light map that the scene asks for
    ExecutionResult result;     ///< of the graph
};

/// Runs the actions of a graph, whose files go to a folder.
using RunInto = std::function<ExecutionResult(const std::vector<Action>& graph, const std::filesystem::path& folder)>;

/// Packs the charts of the light maps of a scene that ask for it, as far as the options want one of their assets.
/// options  get the packed light maps
/// folder   for packed bakes and meshes, which no output has
formats::Result<PreparedMaps> prepareMaps(const Scene& scene, PlanOptions& options, const std::filesystem::path& folder,
                                          const RunInto& run);

}  // namespace lightcook::pipeline
