// Joint trials: parameters and results of trying a light map beside its dominant light, by what pixels show of both.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/assets/light_map/trial.h"
#include "pipeline/document/json_fields.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// The dominant light of a map.
struct DominantTrial {
    std::string fit;     ///< a name of allDominantFits()
    std::string layout;  ///< a name of allDominantLayouts()
};
template <class Fields, Is<DominantTrial> Self>
void describe(Fields& fields, Self& trial) {
    fields.required("fit", trial.fit, "fit of the light");
    fields.required("layout", trial.layout, "its layout");
}

/// Errors of the whole shading under a layout.
struct WholeCandidate {
    std::string layout;
    double visible = 0;  ///< 99th percentile of visible errors
    double relRms = 0;
};
template <class Fields, Is<WholeCandidate> Self>
void describe(Fields& fields, Self& candidate) {
    fields.required("layout", candidate.layout, "layout of the light map");
    fields.required("visible", candidate.visible, kFigure, "99th percentile of visible errors of the whole shading");
    fields.required("rel_rms", candidate.relRms, kFigure, "rel_rms of the whole shading");
}

/// What pixels show beside the light map.
struct JointTrial {
    std::optional<DominantTrial> dominant;  ///< empty: no dominant light
};
template <class Fields, Is<JointTrial> Self>
void describe(Fields& fields, Self& joint) {
    fields.optional("dominant", joint.dominant, "the dominant light; absent: pixels show none");
}

/// Parameters of action "joint-trial". Its inputs are those of action "light-map-trial".
struct JointTrialParameters {
    TrialParameters trial;
    JointTrial joint;
};
template <class Fields, Is<JointTrialParameters> Self>
void describe(Fields& fields, Self& parameters) {
    fields.required("trial", parameters.trial, "trial of the light map");
    fields.required("joint", parameters.joint, "what pixels show beside it");
}

struct JointTrialResult {
    TrialResult trial;
    std::vector<WholeCandidate> whole;
};
template <class Fields, Is<JointTrialResult> Self>
void describe(Fields& fields, Self& result) {
    fields.required("trial", result.trial, "layouts of the light map");
    fields.required("whole", result.whole, "errors of the whole shading under each layout");
}

/// Does the same as tryLightMap, and shades each layout beside the dominant light.
formats::Result<ActionOutcome> tryJointly(const ActionContext& context);
/// Returns the result of either kind of trial; `whole` is empty for a trial of the light map alone.
formats::Result<JointTrialResult> trialIn(const ActionRecord& record);

}  // namespace lightcook::pipeline
