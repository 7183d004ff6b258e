#include "pipeline/cook/trial_actions.h"

#include "formats/light_map_detail.h"
#include "pipeline/assets/action_kind.h"
#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/assets/mesh/mesh_inputs.h"
#include "pipeline/scene/settings.h"

namespace lightcook::pipeline {

TrialParameters trialParametersOf(const Scene& scene, const Needs& needs, const LightMapEntry& entry, const LightMapReduction& reduction,
                                  bool repair, const std::optional<JointTrial>& joint, bool isComplete) {
    const OutputSettings& output = scene.output;
    TrialParameters parameters{
        entry.description,         output.target,           TextureSettings{output.container, output.zstd, output.effort, output.rdo},
        shadingOf(scene, needs),   scene.display,           output.objective,
        reduction.isFlatTried,     reduction.hasDirections, decodeOf(scene, entry, reduction.constantOf.has_value()),
        layoutsFor(output, entry), hasMips(output, entry)};
    parameters.description.repair = repair;
    parameters.description.constantOf = reduction.constantOf;
    const Limits limits = layoutLimits(output, entry);
    const formats::LightMapLayoutInfo& detail = formats::info(formats::kDetailLayout);
    // Smaller mip levels would have none.
    parameters.isDetailTried =
        output.detail.value_or(true) && !reduction.constantOf && !parameters.mips && formats::mayTake(parameters.layouts, detail);
    if (parameters.isDetailTried) parameters.detailLimit = limits[Limit::Visible];
    const bool isMapLimited = *limits[Limit::Error] < kNoErrorLimit || limits[Limit::Visible];
    const std::optional<double>& wholeLimit = output.limits[Limit::WholeVisible];
    parameters.isComplete =
        isComplete || (joint && (isMapLimited || output.limits[Limit::WholeError] || output.budgetBytes || !wholeLimit));
    if (parameters.isComplete) return parameters;  // its figures serve any limits
    if (joint) {
        parameters.limits[Limit::WholeVisible] = wholeLimit;
        return parameters;
    }
    for (const Limit each : {Limit::Error, Limit::Visible}) parameters.limits[each] = limits[each];
    parameters.cost = output.cost;
    return parameters;
}

std::map<std::string, std::filesystem::path> learnedInputsOf(const LightMapEntry& entry) {
    std::map<std::string, std::filesystem::path> inputs = bakeInputs(entry.file, entry.description);
    std::error_code code;
    if (entry.mesh && std::filesystem::exists(*entry.mesh, code))
        inputs.merge(meshInputs(kMeshRole, *entry.mesh, entry.description.lmbake, formats::GltfFiles::Geometry));
    return inputs;
}

Action trialAction(const LightMapEntry& entry, const TrialParameters& parameters, const std::optional<JointTrial>& joint) {
    return {actionId(ActionStep::Trial, entry.name),
            joint ? kJointTrialKind : kLightMapTrialKind,
            entry.name,
            joint ? toJson(JointTrialParameters{parameters, *joint}) : toJson(parameters),
            learnedInputsOf(entry),
            {}};
}

Action completeTrial(Action trial) {
    const auto complete = [](TrialParameters& parameters) {
        parameters.isComplete = true;
        parameters.limits = {};
        parameters.cost = formats::LayoutCost::Bytes;
    };
    if (trial.kind == kJointTrialKind) {
        auto parameters = fromJson<JointTrialParameters>(trial.parameters, trial.id);
        complete(parameters->trial);
        trial.parameters = toJson(*parameters);
    } else {
        auto parameters = fromJson<TrialParameters>(trial.parameters, trial.id);
        complete(*parameters);
        trial.parameters = toJson(*parameters);
    }
    return trial;
}

}  // namespace lightcook::pipeline
