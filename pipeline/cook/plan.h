// Plans a scene: from the scene file and the needs of its materials to the graph of actions.
#pragma once

#include <glm/vec2.hpp>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "pipeline/assets/asset_kind.h"
#include "pipeline/assets/needs.h"
#include "pipeline/cook/allocation.h"
#include "pipeline/graph/action.h"
#include "pipeline/repack/packed_light_map.h"
#include "pipeline/report/skip.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

struct PlanOptions {
    std::optional<std::string> only;      ///< cook the asset, light map, probe or gradient of this name, and its derived assets
    std::optional<std::string> onlyKind;  ///< cook assets of this kind, as the single converters do
    bool repair = false;
    int samples = 1;  ///< random positions per texel quad
    /// Layouts of light maps whose layout is "auto", by name, as their trials chose them. A map that is not here gets a trial instead.
    std::map<std::string, std::string> layouts = {};
    std::map<std::string, PackedLightMap> packed = {};  ///< light maps of the scene whose charts were packed, by name
    std::set<std::string> unlimited = {};               ///< light maps that are held to no default limit (LayoutDecision::unlimited)
    std::optional<int> tableViews = {};                 ///< of tables whose views a budget chooses (areViewsOpen); absent: not chosen yet
};

struct Plan {
    std::vector<Action> actions;      ///< dependencies before dependants
    std::vector<std::string> assets;  ///< in the order of the report
    std::vector<Skip> skipped;
    std::map<std::string, std::string> meshes = {};     ///< mesh assets, and the light maps that they depend on
    std::vector<std::string> undecided;                 ///< light maps whose layout is chosen after action "trial/<name>"
    std::map<std::string, PackedLightMap> packed = {};  ///< by asset: the repacked light map that it belongs to
    std::map<std::string, Json> notes = {};             ///< for the report, by asset
    std::set<std::string> unwanted = {};                ///< assets of the scene that the options do not want
    std::vector<std::string> lightMaps = {};            ///< light maps of the scene file of which the options want an asset
    std::optional<TableBytes> openTables = {};          ///< of tables that wait for the choice of their views: an asset without actions
};

/// Returns the textures of a dominant light under a target.
/// withResidual  with the residual texture, if the target has one
std::vector<SkippedImages> dominantImages(formats::Target target, bool withResidual = true);

/// Returns the GPU memory of images of a size [bytes].
std::uint64_t bytesOf(const std::vector<SkippedImages>& images, const glm::ivec2& size);

/// Returns the name of the mesh asset of a light map with a mesh: that of the mesh, and if several light maps share it also that of the
/// light map, since the UVs are verified against each map.
std::string meshAssetName(const Scene& scene, const LightMapEntry& entry);

/// Returns true if the options want an asset: by its name or that of the entry which it derives from, and by its kind.
bool isWanted(const PlanOptions& options, const std::string& asset, AssetKind kind, const std::string& parent);
/// The same of an asset of a light map, which the light map of the scene file names, too.
bool isWanted(const PlanOptions& options, const std::string& asset, AssetKind kind, const LightMapEntry& entry);

/// Returns true if the options want an asset of a light map of the scene file: itself, its dominant light or its mesh, of either part if it
/// is split.
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
Action verifyAction(const std::string& asset, AssetKind kind, const std::map<std::string, std::filesystem::path>& sources, Json parameters);
/// Returns the action that verifies a light map and its dominant light together, "whole/a" of light map "a".
Action wholeAction(const std::string& lightMap, const std::map<std::string, std::filesystem::path>& sources, Json parameters,
                   std::vector<std::string> dependencies);
/// Returns the action that verifies the seams between the maps of a split light map, "split-seams/a" of light map "a".
/// maps  in the order of the split, as its parameters name them
Action splitSeamsAction(const std::string& lightMap, const std::vector<const PackedLightMap*>& maps, Json parameters,
                        std::vector<std::string> dependencies);

}  // namespace lightcook::pipeline
