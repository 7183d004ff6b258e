#include "pipeline/cook/action_functions.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "pipeline/assets/action_kind.h"
#include "pipeline/assets/asset_kind.h"
#include "pipeline/assets/cubemap/cubemap.h"
#include "pipeline/assets/cubemap/probe_use.h"
#include "pipeline/assets/dominant/dominant.h"
#include "pipeline/assets/gltf/gltf.h"
#include "pipeline/assets/light_map/content.h"
#include "pipeline/assets/light_map/floor.h"
#include "pipeline/assets/light_map/joint_trial.h"
#include "pipeline/assets/light_map/light_map.h"
#include "pipeline/assets/light_map/sampled.h"
#include "pipeline/assets/light_map/trial.h"
#include "pipeline/assets/light_map/whole_errors.h"
#include "pipeline/assets/lut/lut.h"
#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/assets/rsrm/rsrm.h"
#include "pipeline/lint/gradient_facts.h"
#include "pipeline/lint/light_map_facts.h"
#include "pipeline/lint/mesh_facts.h"
#include "pipeline/lint/probe_facts.h"
#include "pipeline/repack/packed_light_map.h"

namespace lightcook::pipeline {
namespace {

/// Actions of an asset kind.
struct AssetActions {
    AssetKind id;
    ActionFunction cook, verify;
};
constexpr std::array kAssetActions = {AssetActions{AssetKind::LightMap, cookLightMap, verifyLightMap},
                                      AssetActions{AssetKind::Dominant, cookDominant, verifyDominant},
                                      AssetActions{AssetKind::Cubemap, cookCubemap, verifyCubemap},
                                      AssetActions{AssetKind::Lut, cookLut, verifyLut},
                                      AssetActions{AssetKind::Rsrm, cookRsrm, verifyRsrm},
                                      AssetActions{AssetKind::Mesh, cookMesh, verifyMesh}};
static_assert(std::ranges::is_sorted(kAssetActions, {}, &AssetActions::id) &&
              kAssetActions.size() == static_cast<std::size_t>(AssetKind::Mesh) + 1);

/// Actions that make no asset (action_kind.h).
struct PlanAction {
    std::string_view kind;
    ActionFunction function;
};
constexpr std::array kPlanActions = {
    PlanAction{kMaterialsKind, readMaterials},     PlanAction{kPackChartsKind, packCharts}, PlanAction{kGltfKind, cookGltf},
    PlanAction{kLightMapTrialKind, tryLightMap},   PlanAction{kJointTrialKind, tryJointly}, PlanAction{kVerifyWholeKind, verifyWhole},
    PlanAction{kContentKind, readLightMapContent}, PlanAction{kFloorKind, measureFloor},    PlanAction{kProbeUseKind, findUnusedProbes},
    PlanAction{kLintLightMapKind, lintLightMap},   PlanAction{kLintMeshKind, lintMesh},     PlanAction{kLintProbeKind, lintProbe},
    PlanAction{kLintGradientKind, lintGradient},   PlanAction{kSampledKind, sampleLightMap}};

formats::Result<ActionOutcome> failUnknownKind(const ActionContext& context) {
    return formats::failure(formats::ErrorCode::FileUnreadable, context.action.asset,
                            "found the kind '" + context.action.kind + "', expected one that this version knows");
}

}  // namespace

ActionFunction actionFunction(const std::string& kind) {
    for (const PlanAction& action : kPlanActions)
        if (action.kind == kind) return action.function;
    const bool isVerify = kind.starts_with(kVerifyKindPrefix);
    const auto asset = assetKindFromName(std::string_view(kind).substr(isVerify ? kVerifyKindPrefix.size() : 0));
    if (!asset) return failUnknownKind;
    const AssetActions& actions = kAssetActions.at(static_cast<std::size_t>(*asset));
    return isVerify ? actions.verify : actions.cook;
}

}  // namespace lightcook::pipeline
