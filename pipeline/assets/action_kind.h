// Kinds and ids of actions. The kind names the function that runs (asset_kind.h); the id names an action within a graph by its step and its
// subject, as "cook/lobby".
#pragma once

#include <array>
#include <string>
#include <string_view>

namespace lightcook::pipeline {

/// Kinds of the actions that make no asset: a plan or lint needs their results, or they put assets together. An asset kind has two kinds of
/// actions: its name, and "verify-" and its name.
inline constexpr const char* kMaterialsKind = "materials";
inline constexpr const char* kContentKind = "light-map-content";
inline constexpr const char* kFloorKind = "light-map-floor";
inline constexpr const char* kProbeUseKind = "probe-use";
inline constexpr const char* kPackChartsKind = "pack-charts";
inline constexpr const char* kLightMapTrialKind = "light-map-trial";
inline constexpr const char* kJointTrialKind = "joint-trial";
inline constexpr const char* kVerifyWholeKind = "verify-whole";
inline constexpr const char* kSampledKind = "sample-light-map";
inline constexpr const char* kGltfKind = "gltf";
inline constexpr const char* kLintLightMapKind = "lint-light-map";
inline constexpr const char* kLintMeshKind = "lint-mesh";
inline constexpr const char* kLintProbeKind = "lint-probe";
inline constexpr const char* kLintGradientKind = "lint-gradient";
inline constexpr std::string_view kVerifyKindPrefix = "verify-";

/// Id of the only action of its kind.
inline constexpr const char* kProbeUseId = kProbeUseKind;

enum class ActionStep {
    Materials,
    Content,
    Floor,
    Pack,
    Trial,
    Cook,
    Verify,
    Whole,
    Gltf,
    LintLightMap,
    LintMesh,
    LintProbe,
    LintGradient
};

/// Prefixes of ids, in the order of ActionStep.
inline constexpr std::array<std::string_view, 13> kActionIdPrefixes = {
    "materials/", "content/", "floor/",          "pack/",      "trial/",      "cook/",         "verify/",
    "whole/",     "gltf/",    "lint/light-map/", "lint/mesh/", "lint/probe/", "lint/gradient/"};
static_assert(kActionIdPrefixes.size() == static_cast<std::size_t>(ActionStep::LintGradient) + 1);

constexpr std::string_view actionIdPrefix(ActionStep step) {
    return kActionIdPrefixes[static_cast<std::size_t>(step)];
}

/// Returns the id of an action.
/// subject  the asset; of ActionStep::Materials the path of the mesh
inline std::string actionId(ActionStep step, std::string_view subject) {
    return std::string(actionIdPrefix(step)).append(subject);
}

/// Returns true if the id of an action is of a step.
constexpr bool isOfStep(std::string_view id, ActionStep step) {
    return id.starts_with(actionIdPrefix(step));
}

/// Returns the subject of an id that is of a step.
inline std::string actionSubject(std::string_view id, ActionStep step) {
    return std::string(id.substr(actionIdPrefix(step).size()));
}

}  // namespace lightcook::pipeline
