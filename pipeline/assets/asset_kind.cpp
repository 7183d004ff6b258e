#include "pipeline/assets/asset_kind.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "formats/light_map_layout.h"
#include "formats/vocabulary.h"
#include "pipeline/assets/action_kind.h"
#include "pipeline/assets/cubemap/cubemap.h"
#include "pipeline/assets/cubemap/probe_use.h"
#include "pipeline/assets/dominant/dominant.h"
#include "pipeline/assets/gltf/gltf.h"
#include "pipeline/assets/light_map/chart_split.h"
#include "pipeline/assets/light_map/content.h"
#include "pipeline/assets/light_map/floor.h"
#include "pipeline/assets/light_map/joint_trial.h"
#include "pipeline/assets/light_map/light_map.h"
#include "pipeline/assets/light_map/split_seams.h"
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

/// Returns the endings of every layout: a light map's layout may not be chosen yet when names are checked.
std::vector<std::string> lightMapEndings() {
    std::vector<std::string> endings;
    for (const formats::LightMapLayoutInfo& layout : formats::allLightMapLayouts())
        for (const formats::LightMapTextureInfo& texture : layout.textures)
            if (const std::string ending = fmt::format("_{}", texture.name); std::ranges::find(endings, ending) == endings.end())
                endings.push_back(ending);
    for (const char* role : {kIndexRole, kTablesRole}) endings.push_back(fmt::format("_{}", role));
    return endings;
}
std::vector<std::string> dominantEndings() {
    return {"_direction", "_residual", "_intensity"};
}
std::vector<std::string> lutEndings() {
    return {"_c0236", "_d0236", "_cd78"};
}
std::vector<std::string> noEndings() {
    return {};
}

constexpr std::array kAssetKinds = {
    AssetKindInfo{.id = AssetKind::LightMap,
                  .name = "light-map",
                  .shortCaption = "light map",
                  .caption = "SH light map in the textures of its layout",
                  .quantity = "incident radiance",
                  .conventions = {.units = "radiometric", .phase = "none", .frame = "world"},
                  .filter = "linear",
                  .isHeldToMaxError = true,
                  .sceneSection = "light_map",
                  .cook = cookLightMap,
                  .verify = verifyLightMap,
                  .fileEndings = lightMapEndings},
    AssetKindInfo{.id = AssetKind::Dominant,
                  .name = "dominant",
                  .shortCaption = "dominant light",
                  .caption = "dominant light of each texel of a light map: direction and intensity",
                  .quantity = "incident radiance, a delta from the direction",
                  .conventions = {.units = "radiometric", .phase = {}, .frame = "world"},
                  .filter = "linear",
                  .isHeldToMaxError = false,
                  .sceneSection = "light_map",
                  .cook = cookDominant,
                  .verify = verifyDominant,
                  .fileEndings = dominantEndings},
    AssetKindInfo{.id = AssetKind::Cubemap,
                  .name = "cubemap",
                  .shortCaption = "cubemap",
                  .caption = "prefiltered cubemap of a probe, divided by its own area specular",
                  .quantity = "prefiltered radiance over its own area specular",
                  .conventions = {.units = "radiometric", .phase = "none", .frame = "world"},
                  .filter = "trilinear",
                  .isHeldToMaxError = false,
                  .sceneSection = "probe",
                  .cook = cookCubemap,
                  .verify = verifyCubemap,
                  .fileEndings = noEndings},
    AssetKindInfo{.id = AssetKind::Lut,
                  .name = "lut",
                  .shortCaption = "specular tables",
                  .caption = "specular tables: the Cook-Torrance kernel in SH over view angle and roughness",
                  .quantity = "SH coefficients of the area-specular kernel",
                  .conventions = {.units = {}, .phase = "none", .frame = "z the normal, the view in the x-z plane"},
                  .filter = "linear",
                  .isHeldToMaxError = false,
                  .sceneSection = "tables",
                  .cook = cookLut,
                  .verify = verifyLut,
                  .fileEndings = lutEndings},
    AssetKindInfo{.id = AssetKind::Rsrm,
                  .name = "rsrm",
                  .shortCaption = "reflection map",
                  .caption = "radially symmetric reflection map of a gradient",
                  .quantity = "exit radiance by Phong exponent (rows) over the angle to the axis (columns, north to south)",
                  .conventions = {.units = "radiometric", .phase = {}, .frame = {}},
                  .filter = "linear",
                  .isHeldToMaxError = false,
                  .sceneSection = "gradient",
                  .cook = cookRsrm,
                  .verify = verifyRsrm,
                  .fileEndings = noEndings},
    AssetKindInfo{.id = AssetKind::Mesh,
                  .name = "mesh",
                  .shortCaption = "mesh",
                  .caption = "mesh with quantized light-map UVs",
                  .quantity = {},
                  .conventions = {},
                  .filter = "linear",
                  .isHeldToMaxError = true,
                  .sceneSection = "light_map",
                  .cook = cookMesh,
                  .verify = verifyMesh,
                  .fileEndings = noEndings},
};
static_assert(formats::isCompleteTable(kAssetKinds, AssetKind::Mesh));

/// Actions that make no asset (action_kind.h).
struct PlanAction {
    std::string_view kind;
    ActionFunction function;
};
constexpr std::array kPlanActions = {PlanAction{kMaterialsKind, readMaterials},     PlanAction{kSplitChartsKind, splitCharts},
                                     PlanAction{kPackChartsKind, packCharts},       PlanAction{kGltfKind, cookGltf},
                                     PlanAction{kLightMapTrialKind, tryLightMap},   PlanAction{kJointTrialKind, tryJointly},
                                     PlanAction{kVerifyWholeKind, verifyWhole},     PlanAction{kVerifySplitSeamsKind, verifySplitSeams},
                                     PlanAction{kContentKind, readLightMapContent}, PlanAction{kFloorKind, measureFloor},
                                     PlanAction{kProbeUseKind, findUnusedProbes},   PlanAction{kLintLightMapKind, lintLightMap},
                                     PlanAction{kLintMeshKind, lintMesh},           PlanAction{kLintProbeKind, lintProbe},
                                     PlanAction{kLintGradientKind, lintGradient}};

formats::Result<ActionOutcome> failUnknownKind(const ActionContext& context) {
    return formats::failure(formats::ErrorCode::FileUnreadable, context.action.asset,
                            "found the kind '" + context.action.kind + "', expected one that this version knows");
}

}  // namespace

std::span<const AssetKindInfo> allAssetKinds() {
    return kAssetKinds;
}

const AssetKindInfo& info(AssetKind kind) {
    return kAssetKinds.at(static_cast<std::size_t>(kind));
}

std::optional<AssetKind> assetKindFromName(std::string_view name) {
    const AssetKindInfo* row = formats::findByName(allAssetKinds(), name);
    return row == nullptr ? std::nullopt : std::optional(row->id);
}

std::vector<std::string> EnumNames<AssetKind>::all() {
    return formats::namesOf(allAssetKinds());
}

ActionFunction actionFunction(const std::string& kind) {
    for (const PlanAction& action : kPlanActions)
        if (action.kind == kind) return action.function;
    const bool isVerify = kind.starts_with(kVerifyKindPrefix);
    const auto asset = assetKindFromName(std::string_view(kind).substr(isVerify ? kVerifyKindPrefix.size() : 0));
    if (!asset) return failUnknownKind;
    return isVerify ? info(*asset).verify : info(*asset).cook;
}

}  // namespace lightcook::pipeline
