// Joint trials: parameters and results of trying a light map together with the assets that share the memory of its scene.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/assets/light_map/trial.h"
#include "pipeline/document/json_fields.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// Dominant lights that a trial considers.
struct DominantTrial {
    std::string fit;                   ///< a name of allDominantFits()
    std::vector<std::string> layouts;  ///< names of allDominantLayouts()
};
template <class Fields, Is<DominantTrial> Self>
void describe(Fields& fields, Self& trial) {
    fields.required("fit", trial.fit, "fit of the light");
    fields.required("layouts", trial.layouts, "layouts that are tried");
}

/// Size and error of one dominant layout.
struct DominantCandidate {
    std::string layout;
    std::uint64_t bytesGpu = 0;
    double relRms = 0;  ///< of its part of the whole shading at the places of the trial
};
template <class Fields, Is<DominantCandidate> Self>
void describe(Fields& fields, Self& candidate) {
    fields.required("layout", candidate.layout, "layout of the dominant light");
    fields.required("bytes_gpu", candidate.bytesGpu, "GPU memory [bytes]");
    fields.required("rel_rms", candidate.relRms, kFigure, "rel_rms of the light that it adds");
}

/// Errors of the whole shading under a pair of layouts.
struct WholeCandidate {
    std::string lightMap, dominant;  ///< layouts; dominant: empty where the scene needs none
    double visible = 0;              ///< 99th percentile of visible errors
    double relRms = 0;
};
template <class Fields, Is<WholeCandidate> Self>
void describe(Fields& fields, Self& candidate) {
    fields.required("light_map", candidate.lightMap, "layout of the light map");
    fields.required("dominant", candidate.dominant, "layout of the dominant light; empty: the map has none");
    fields.required("visible", candidate.visible, kFigure, "99th percentile of visible errors of the whole shading");
    fields.required("rel_rms", candidate.relRms, kFigure, "rel_rms of the whole shading");
}

/// Assets that share the memory of a scene with the light map: their layouts are tried with its own.
struct JointTrial {
    std::optional<std::string> layout;      ///< of the light map, where the scene file names it
    std::optional<DominantTrial> dominant;  ///< empty: the map has no dominant light
};
template <class Fields, Is<JointTrial> Self>
void describe(Fields& fields, Self& joint) {
    fields.optional("layout", joint.layout, "layout of the light map, if the scene file names it");
    fields.optional("dominant", joint.dominant, "dominant lights that are tried; absent: the map has none");
}

/// Parameters of action "joint-trial". Its inputs are those of action "light-map-trial".
struct JointTrialParameters {
    TrialParameters trial;
    JointTrial joint;
};
template <class Fields, Is<JointTrialParameters> Self>
void describe(Fields& fields, Self& parameters) {
    fields.required("trial", parameters.trial, "trial of the light map");
    fields.required("joint", parameters.joint, "assets that share the memory of the scene");
}

struct JointTrialResult {
    TrialResult trial;
    std::vector<DominantCandidate> dominants;
    std::vector<WholeCandidate> whole;
};
template <class Fields, Is<JointTrialResult> Self>
void describe(Fields& fields, Self& result) {
    fields.required("trial", result.trial, "layouts of the light map");
    fields.required("dominants", result.dominants, "layouts of the dominant light");
    fields.required("whole", result.whole, "errors of the whole shading, for each pair of layouts");
}

/// Does the same as tryLightMap, and shades each layout with each layout of the dominant light.
formats::Result<ActionOutcome> tryJointly(const ActionContext& context);
/// Returns the result of either kind of trial; `whole` is empty for a trial of the light map alone.
formats::Result<JointTrialResult> trialIn(const ActionRecord& record);

}  // namespace lightcook::pipeline
