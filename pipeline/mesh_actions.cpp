#include "pipeline/mesh_actions.h"

#include <fmt/format.h>

#include "formats/mesh.h"
#include "pipeline/bands.h"
#include "pipeline/figures_json.h"
#include "pipeline/light_map_actions.h"
#include "verify/mesh_shift.h"

namespace pipeline {
namespace {

using formats::Result;

/// Bytes of GPU memory that the light map asks of a vertex: two 16-bit UVs.
constexpr std::int64_t kLightMapUvBytes = 4;

Json toJson(const formats::MaterialNeeds& material) {
    return {{"name", material.name},
            {"normal_map", material.hasNormalMap},
            {"specular", material.isSpecular},
            {"m", {material.mMin, material.mMax}},
            {"f0", {material.f0Min, material.f0Max}}};
}

Json toJson(const formats::DracoOptions& options) {
    return {{"position_bits", options.positionBits},
            {"normal_bits", options.normalBits},
            {"uv_bits", options.uvBits},
            {"light_map_uv_bits", options.lightMapUvBits}};
}

}  // namespace

Result<ActionOutcome> readMaterials(const ActionContext& context) {
    const auto scene = formats::GltfScene::load(context.action.inputs.at("mesh"));
    if (!scene) return tl::make_unexpected(scene.error());
    ActionOutcome outcome;
    outcome.result["materials"] = Json::array();
    for (const formats::MaterialNeeds& material : scene->materials()) outcome.result["materials"].push_back(toJson(material));
    return outcome;
}

Result<ActionOutcome> cookMesh(const ActionContext& context) {
    const auto& source = context.action.inputs.at("mesh");
    const auto scene = formats::GltfScene::load(source);
    if (!scene) return tl::make_unexpected(scene.error());
    if (!scene->hasLightMapUvs())
        return formats::failure(formats::ErrorCode::WrongShape, source.string(),
                                "found a primitive without TEXCOORD_1, expected light-map UVs on every primitive");
    const formats::DracoOptions options;
    const std::string file = context.action.asset + ".glb";
    const auto size = scene->writeDraco(context.folder / file, options);
    if (!size) return tl::make_unexpected(size.error());
    ActionOutcome outcome;
    outcome.files = {file};
    outcome.result["asset"] = {{"name", context.action.asset},
                               {"kind", "mesh"},
                               {"layout", "glb-draco"},
                               {"width", 0},
                               {"height", 0},
                               {"file", file},
                               {"bytes_gpu", size->vertexCount * kLightMapUvBytes},
                               {"bytes_disk", size->fileBytesOut},
                               {"vertices", size->vertexCount},
                               {"triangles", size->triangleCount},
                               {"quantization", toJson(options)},
                               {"textures", Json::array()},
                               {"source", {{"description", context.action.parameters.at("description")}}}};
    outcome.result["bytes_in"] = size->fileBytesIn;
    return outcome;
}

Result<ActionOutcome> verifyMesh(const ActionContext& context) {
    const Json& asset = context.upstream.at(0)->result.at("asset");
    const auto source = formats::GltfScene::load(context.action.inputs.at("mesh"));
    if (!source) return tl::make_unexpected(source.error());
    const auto cooked = formats::GltfScene::load(context.upstreamFolder / asset.at("file").get<std::string>());
    if (!cooked) return tl::make_unexpected(cooked.error());
    const auto moved = source->errorOf(*cooked);
    if (!moved) return tl::make_unexpected(moved.error());

    const auto opened = openLightMap(context, asset.at("source").at("description"));
    if (!opened) return tl::make_unexpected(opened.error());
    LightMapSource& bake = **opened;
    const auto surveyed = surveyKey(bake, context);
    if (!surveyed) return tl::make_unexpected(surveyed.error());
    const double key = *surveyed;
    const verify::MeshShift shift{moved->lightMapUv * bake.width(), moved->lightMapUv * bake.height(), moved->normalRadians};
    using verify::ErrorAccumulator;
    const auto parts = forEachBand<ErrorAccumulator>(
        bake.bandCount(), context, "verify " + context.action.asset, [&](int index) -> Result<ErrorAccumulator> {
            const auto band = bake.bandWithMargin(index, 0, 1);
            if (!band) return tl::make_unexpected(band.error());
            ErrorAccumulator part(key);
            verify::addMeshShiftErrors(*band, index * kBandRows, bake.bandRows(index), shift, key, part);
            return part;
        });
    if (!parts) return tl::make_unexpected(parts.error());
    ErrorAccumulator errors(key);
    for (const ErrorAccumulator& part : *parts) errors.merge(part);
    verify::StageError stage;
    stage.name = "quantize";
    stage.diffuse = errors.figures();
    ActionOutcome outcome;
    outcome.result["verdict"] = verdict({stage}, context.action.parameters.at("max_error").get<double>());
    outcome.result["mesh_error"] = {
        {"position", moved->position}, {"normal_radians", moved->normalRadians}, {"light_map_uv", moved->lightMapUv}};
    return outcome;
}

}  // namespace pipeline
