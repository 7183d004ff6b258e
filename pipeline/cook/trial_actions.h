// Trials of light maps as actions of a graph.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>

#include "pipeline/assets/light_map/joint_trial.h"
#include "pipeline/assets/needs.h"
#include "pipeline/cook/contents.h"
#include "pipeline/graph/action.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

/// Returns the parameters of the trial of a light map.
/// joint       assets whose layouts are chosen together with the map's; empty: none
/// isComplete  every layout is measured on the whole map. So it is in a joint trial under a budget, and under other limits than that on
///             visible errors
TrialParameters trialParametersOf(const Scene& scene, const Needs& needs, const LightMapEntry& entry, const LightMapReduction& reduction,
                                  bool repair, const std::optional<JointTrial>& joint, bool isComplete);

/// Returns the inputs of a light map that may get a learned layout. No two learned bases may meet on an island of the mesh, so the mesh is
/// one of them if it exists.
std::map<std::string, std::filesystem::path> learnedInputsOf(const LightMapEntry& entry);

/// Returns the trial of a light map, "trial/" and its name.
/// joint  chooses the layout of the dominant light, too; empty: the trial is of the light map alone
Action trialAction(const LightMapEntry& entry, const TrialParameters& parameters, const std::optional<JointTrial>& joint);
/// Returns a trial as a complete one.
Action completeTrial(Action trial);

}  // namespace lightcook::pipeline
