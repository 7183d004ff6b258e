// Checks of plausibility of a scene: facts of its inputs from cached actions, judged, and compared with what the scene file allows.
#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "pipeline/graph/action.h"
#include "pipeline/lint/finding.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

/// Returns the actions that gather the facts of a scene's inputs.
/// assets  the light maps and probes that are meant; none: all
std::vector<Action> planLint(const Scene& scene, bool repair, const std::optional<std::set<std::string>>& assets = {});

/// Judges a scene.
/// records    by action id, of planLint() and of the actions "materials/..." of the meshes; what has no record is not judged
/// isStrict   makes every finding that the scene file does not allow an error
formats::Result<std::vector<Finding>> judgeScene(const Scene& scene, const std::map<std::string, ActionRecord>& records, bool isStrict);

}  // namespace lightcook::pipeline
