// Light maps: cooked into the textures of a layout, and verified from the bytes on disk. docs/theory/layouts.md describes the layouts.
#pragma once

#include <optional>
#include <string_view>

#include "formats/light_map_detail.h"
#include "formats/light_map_layout.h"
#include "formats/target.h"
#include "pipeline/assets/light_map/kept_map.h"
#include "pipeline/assets/light_map/shading.h"
#include "pipeline/assets/light_map/source.h"
#include "pipeline/assets/textures.h"
#include "pipeline/graph/action.h"
#include "pipeline/limits/limits.h"

namespace lightcook::pipeline {

/// Texture of a learned layout with the cluster of each block, where no mesh names them.
inline constexpr const char* kIndexRole = "index";
/// Returns the size of that texture for a light map: RGBA8, four neighbours of a row of blocks of 4 x 4 in a texel.
inline int indexWidth(int mapWidth) {
    return (mapWidth + 15) / 16;
}
inline int indexHeight(int mapHeight) {
    return (mapHeight + 3) / 4;
}

/// Texture of a learned layout with the factors of its decode: RGBA16F, a row for each cluster (shaders/light_map_basis.glsl). The constant
/// of this name holds its file.
inline constexpr const char* kTablesRole = "tables";
/// Returns true for the textures of a light map that are not of its layout's table: they are fetched texel by texel, and have sizes of
/// their own.
inline bool isLookupRole(std::string_view role) {
    return role == kIndexRole || role == kTablesRole || role == formats::kCoverageRole || formats::isOfDetail(role);
}

/// Returns true if a layout has learned bases for each cluster of charts: then a mesh names the cluster of each vertex.
/// layout  with or without detail (DetailedLayout::name)
inline bool hasLearnedBases(std::string_view layout) {
    const auto known = formats::lightMapLayoutFromName(layout.substr(0, layout.find('+')));
    return known && formats::info(*known).isLearned();
}
/// Returns true if the encoder of a layout has an objective to minimize.
inline bool hasObjective(std::string_view layout) {
    const auto known = formats::lightMapLayoutFromName(layout);
    return known && formats::info(*known).hasObjective();
}

/// Tiles of a light map get detail (detail.h) until 99 % of its samples are within a limit.
struct DetailParameters {
    SceneView view;
    double limit = 0;  ///< on visible errors
};
template <class Fields, Is<DetailParameters> Self>
void describe(Fields& fields, Self& detail) {
    fields.required("view", detail.view, "scene and display that visible errors are judged on");
    fields.required("limit", detail.limit, "limit on the visible errors of 99 % of the samples");
}

/// Parameters of the cook action. Its inputs are "source", and "mesh" if the layout is learned and the map has a mesh.
struct LightMapParameters {
    formats::LightMapDescription description;
    std::string layout;
    formats::Target target = formats::Target::Bc;
    TextureSettings textures;
    std::optional<SceneView> visible = std::nullopt;  ///< of a layout with an objective; absent: "energy"
    bool mips = false;                                ///< as many mip levels as keep charts apart (mips.h)
    formats::LightMapFilter filter = formats::LightMapFilter::Hardware;
    std::optional<DetailParameters> detail = std::nullopt;  ///< absent: no tile has detail
    bool isDominantDerived = false;                         ///< the manifest says so: the pixels are the same
    std::optional<KeptMap> kept = std::nullopt;             ///< of the last cook; absent: the map is planned
};
template <class Fields, Is<LightMapParameters> Self>
void describe(Fields& fields, Self& parameters) {
    fields.required("description", parameters.description, "conventions of the light map");
    fields.required("layout", parameters.layout, "layout");
    fields.required("target", parameters.target, "target");
    fields.required("textures", parameters.textures, "settings of the files");
    fields.optional("visible", parameters.visible, "scene and display of objective visible; absent: objective energy");
    fields.presentIf(parameters.mips, "mips", parameters.mips, "true for mip levels");
    fields.presentIf(parameters.filter != formats::LightMapFilter::Hardware, "filter", parameters.filter, "filter of the shader");
    fields.presentIf(parameters.isDominantDerived, "derived_dominant", parameters.isDominantDerived,
                     "true if the shader derives the dominant light from the map");
    fields.optional("detail", parameters.detail, "limit that tiles get detail for; absent: none do");
    fields.optional("kept", parameters.kept, "plan of an earlier bake that the map is encoded with; absent: it is planned");
}

/// Parameters of the verify action. Its inputs are "source" and optionally "mesh" and traced light.
struct LightMapVerifyParameters {
    verify::LightMapShading shading;
    int samples = 1;  ///< random places on the surface of each texel
    lighting::DisplaySettings display;
    Limits limits;
    std::optional<KeptMap> kept = std::nullopt;  ///< of the last cook; absent: the keys are those of the bake
};
template <class Fields, Is<LightMapVerifyParameters> Self>
void describe(Fields& fields, Self& parameters) {
    fields.required("shading", parameters.shading, "materials that are shaded");
    fields.required("samples", parameters.samples, "random places on the surface of each texel");
    fields.required("display", parameters.display, "display that visible errors are judged on");
    describe(fields, parameters.limits, kAssetLimits);
    describeKeptKeys(fields, parameters.kept);
}

/// Numbers of a constant that the metadata of the textures has, too; larger constants lie in the manifest alone.
inline constexpr std::size_t kLargestMetadataConstant = 16;

formats::Result<ActionOutcome> cookLightMap(const ActionContext& context);
/// Verifies the shaded light of the cooked textures against the bake, at texels and between them, with a certified bound.
formats::Result<ActionOutcome> verifyLightMap(const ActionContext& context);

}  // namespace lightcook::pipeline
