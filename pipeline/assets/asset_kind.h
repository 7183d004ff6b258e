// Kinds of assets that a scene is cooked into. One row for each kind; a kind's cook and verification lie together in assets/<kind>/. A kind
// has one name in scene file, commands, manifest and report.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/document/json_fields.h"

namespace lightcook::pipeline {

enum class AssetKind { LightMap, Dominant, Cubemap, Lut, Rsrm, Mesh };

/// Conventions of the shared shaders that a manifest states for an asset, and that contract.cpp holds it to. Empty: the kind has no such
/// member.
struct AssetConventions {
    std::string_view units, phase, frame;
};

struct AssetKindInfo {
    AssetKind id;
    std::string_view name;          ///< "light-map"
    std::string_view shortCaption;  ///< a few words for tables and lists: "light map"
    std::string_view caption;       ///< one line for help texts, reports and documents
    std::string_view quantity;      ///< stored in the textures
    AssetConventions conventions;
    std::string_view filter;                    ///< that its textures are sampled and verified with: linear or trilinear
    std::string_view sceneSection;              ///< table of the scene file that its assets come from
    std::vector<std::string> (*fileEndings)();  ///< of its files' names, after the asset's name: "_l0"
};

/// Returns every kind, in the order of the enumeration.
std::span<const AssetKindInfo> allAssetKinds();
const AssetKindInfo& info(AssetKind kind);
std::optional<AssetKind> assetKindFromName(std::string_view name);

template <>
struct EnumNames<AssetKind> {
    static std::vector<std::string> all();
};

}  // namespace lightcook::pipeline
