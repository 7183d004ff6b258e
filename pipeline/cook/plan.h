// From a scene and its needs to the graph of actions.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/graph/action.h"
#include "pipeline/scene/needs.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

struct PlanOptions {
    std::optional<std::string> only;      ///< cook the asset, light map, probe or gradient of this name and what derives from it
    std::optional<std::string> onlyKind;  ///< cook assets of this kind: what the single converters do
    bool repair = false;
    int samples = 1;  ///< random positions per texel quad
    /// Of light maps whose layout is "auto", by name: what their trials chose. A map that is not here gets its trial instead of a cook.
    std::map<std::string, std::string> layouts = {};
};

struct Plan {
    std::vector<Action> actions;      ///< dependencies before dependants
    std::vector<std::string> assets;  ///< in the order of the report
    std::vector<Skip> skipped;
    std::map<std::string, std::string> meshes = {};  ///< mesh assets, and the light maps that they are cooked after
    std::vector<std::string> undecided;              ///< light maps whose layout has to be chosen first: action "trial/a" tells
};

/// The actions that have to be known before the rest can be planned: what the meshes' materials ask for.
std::vector<Action> planNeeds(const Scene& scene);
/// An asset "a" has an action "cook/a" and an action "verify/a".
formats::Result<Plan> planScene(const Scene& scene, const Needs& needs, const PlanOptions& options);

/// Whether a layout has bases of its own for each cluster of charts: then a mesh bears the cluster of each vertex.
bool hasLearnedBases(const std::string& layout);

/// The verify action of an asset alone, for a cooked scene that is opened again. sources: by role, as the manifest names them.
Action verifyAction(const std::string& asset, const std::string& kind, const std::map<std::string, std::filesystem::path>& sources,
                    Json parameters);

}  // namespace lightcook::pipeline
