// Plans a scene: from the scene file and the needs of its materials to the graph of actions.
#pragma once

#include <glm/vec2.hpp>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "formats/light_map_layout.h"
#include "pipeline/assets/asset_kind.h"
#include "pipeline/assets/needs.h"
#include "pipeline/cook/allocation.h"
#include "pipeline/graph/action.h"
#include "pipeline/manifest/cook_record.h"
#include "pipeline/repack/packed_light_map.h"
#include "pipeline/report/skip.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

struct PlanOptions {
    std::optional<std::string> only;      ///< cook the asset, light map, probe or gradient of this name, and its derived assets
    std::optional<std::string> onlyKind;  ///< cook assets of this kind, as the single converters do
    bool repair = false;
    int samples = 1;  ///< random positions per texel quad
    Decisions decisions = {};
    std::map<std::string, PackedLightMap> packed = {};  ///< light maps of the scene whose charts were packed, by name
    std::optional<std::set<std::string>> assets = {};   ///< of a cook that is planned again: CookRecord::assets, in place of `only`
    bool areTrialsComplete = false;                     ///< TrialParameters::isComplete
};

struct Plan {
    std::vector<Action> actions;      ///< dependencies before dependants
    std::vector<std::string> assets;  ///< in the order of the report
    std::vector<Skip> skipped;
    std::map<std::string, std::string> meshes = {};     ///< mesh assets, and the light maps that they depend on
    std::vector<std::string> undecided;                 ///< light maps whose layout is chosen after action "trial/<name>"
    std::map<std::string, PackedLightMap> packed = {};  ///< by asset: the repacked light map that it belongs to
    std::map<std::string, Json> notes = {};             ///< for the report, by asset
    std::set<std::string> wanted = {}, unwanted = {};   ///< assets of the scene that the options want, and do not want
    std::vector<std::string> lightMaps = {};            ///< light maps of the scene file of which the options want an asset
    std::optional<TableBytes> openTables = {};          ///< of tables that wait for the choice of their views: an asset without actions
};

/// Returns the textures of a layout under a filter, without learned tables.
std::vector<SkippedImages> texturesOf(const formats::LightMapLayoutInfo& layout, formats::Target target, formats::LightMapFilter filter);

/// Returns the GPU memory of images of a size [bytes].
std::uint64_t bytesOf(const std::vector<SkippedImages>& images, const glm::ivec2& size);

/// Returns the name of the mesh asset of a light map with a mesh: that of the mesh, and if several light maps share it also that of the
/// light map, since the UVs are verified against each map.
std::string meshAssetName(const Scene& scene, const LightMapEntry& entry);

/// Returns true if the options want an asset: by its name or that of the entry which it derives from, and by its kind.
bool isWanted(const PlanOptions& options, const std::string& asset, AssetKind kind, const std::string& parent);
/// Returns true if the options want an asset of a light map: itself, its dominant light or its mesh.
bool isAnyWanted(const Scene& scene, const PlanOptions& options, const LightMapEntry& entry);

/// Returns the actions that run before the plan: they read the materials of the meshes.
std::vector<Action> planNeeds(const Scene& scene);
/// Plans the assets of a scene: asset "a" gets an action "cook/a" and an action "verify/a".
formats::Result<Plan> planScene(const Scene& scene, const Needs& needs, const PlanOptions& options);

/// Name of the specular tables.
inline constexpr const char* kTablesName = "specular";
/// Returns the name of the dominant light of a light map.
std::string dominantNameOf(const std::string& lightMap);

/// Returns the verify action of an asset. sources: by role, as the manifest names them.
Action verifyAction(const std::string& asset, AssetKind kind, const RoleFiles& sources, Json parameters);

/// Returns an action of a plan. It is there.
const Action& actionOf(const Plan& plan, const std::string& id);
/// Returns the files of the user's that a planned asset is cooked and verified from, by role.
RoleFiles sourcesOf(const Plan& plan, const std::string& asset);
/// Returns what lint looks at for some assets: these, and the light maps whose dominant lights are among them.
std::set<std::string> inputsOf(const Scene& scene, std::set<std::string> assets);

}  // namespace lightcook::pipeline
