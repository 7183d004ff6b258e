#include "pipeline/assets/asset_kind.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "formats/light_map_layout.h"
#include "formats/vocabulary.h"
#include "pipeline/assets/light_map/light_map.h"

namespace lightcook::pipeline {
namespace {

/// Returns the endings of every layout: a light map's layout may not be chosen yet when names are checked.
std::vector<std::string> lightMapEndings() {
    std::vector<std::string> endings;
    for (const formats::LightMapLayoutInfo& layout : formats::allLightMapLayouts())
        for (const formats::LightMapTextureInfo& texture : layout.textures)
            if (const std::string ending = fmt::format("_{}", texture.name); std::ranges::find(endings, ending) == endings.end())
                endings.push_back(ending);
    for (const std::string_view role : {std::string_view(kIndexRole), std::string_view(kTablesRole), formats::kCoverageRole})
        endings.push_back(fmt::format("_{}", role));
    for (const formats::DetailTextureInfo& texture : formats::kDetailTextures) endings.push_back(fmt::format("_{}", texture.name));
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
                  .sceneSection = "light_map",
                  .fileEndings = lightMapEndings},
    AssetKindInfo{.id = AssetKind::Dominant,
                  .name = "dominant",
                  .shortCaption = "dominant light",
                  .caption = "dominant light of each texel of a light map: direction and intensity",
                  .quantity = "incident radiance, a delta from the direction",
                  .conventions = {.units = "radiometric", .phase = {}, .frame = "world"},
                  .filter = "linear",
                  .sceneSection = "light_map",
                  .fileEndings = dominantEndings},
    AssetKindInfo{.id = AssetKind::Cubemap,
                  .name = "cubemap",
                  .shortCaption = "cubemap",
                  .caption = "prefiltered cubemap of a probe, divided by its own area specular",
                  .quantity = "prefiltered radiance over its own area specular",
                  .conventions = {.units = "radiometric", .phase = "none", .frame = "world"},
                  .filter = "trilinear",
                  .sceneSection = "probe",
                  .fileEndings = noEndings},
    AssetKindInfo{.id = AssetKind::Lut,
                  .name = "lut",
                  .shortCaption = "specular tables",
                  .caption = "specular tables: the Cook-Torrance kernel in SH over view angle and roughness",
                  .quantity = "SH coefficients of the area-specular kernel",
                  .conventions = {.units = {}, .phase = "none", .frame = "z the normal, the view in the x-z plane"},
                  .filter = "linear",
                  .sceneSection = "tables",
                  .fileEndings = lutEndings},
    AssetKindInfo{.id = AssetKind::Rsrm,
                  .name = "rsrm",
                  .shortCaption = "reflection map",
                  .caption = "radially symmetric reflection map of a gradient",
                  .quantity = "exit radiance by Phong exponent (rows) over the angle to the axis (columns, north to south)",
                  .conventions = {.units = "radiometric", .phase = {}, .frame = {}},
                  .filter = "linear",
                  .sceneSection = "gradient",
                  .fileEndings = noEndings},
    AssetKindInfo{.id = AssetKind::Mesh,
                  .name = "mesh",
                  .shortCaption = "mesh",
                  .caption = "mesh with quantized light-map UVs",
                  .quantity = {},
                  .conventions = {},
                  .filter = "linear",
                  .sceneSection = "light_map",
                  .fileEndings = noEndings},
};
static_assert(formats::isCompleteTable(kAssetKinds, AssetKind::Mesh));

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

}  // namespace lightcook::pipeline
