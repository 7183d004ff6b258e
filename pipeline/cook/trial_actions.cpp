#include "pipeline/cook/trial_actions.h"

#include "pipeline/assets/action_kind.h"
#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/assets/mesh/mesh_inputs.h"
#include "pipeline/scene/settings.h"

namespace lightcook::pipeline {

TrialParameters trialParametersOf(const Scene& scene, const Needs& needs, const LightMapEntry& entry, const LightMapReduction& reduction,
                                  bool repair) {
    const OutputSettings& output = scene.output;
    TrialParameters parameters{
        entry.description,         output.target,           TextureSettings{output.container, output.zstd, output.effort, output.rdo},
        shadingOf(scene, needs),   scene.display,           output.objective,
        reduction.isFlatTried,     reduction.hasDirections, decodeOf(scene, entry, reduction.constantOf.has_value()),
        layoutsFor(output, entry), hasMips(output, entry)};
    parameters.description.repair = repair;
    parameters.description.constantOf = reduction.constantOf;
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

}  // namespace lightcook::pipeline
