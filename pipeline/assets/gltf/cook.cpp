#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "formats/gltf_scene.h"
#include "formats/png.h"
#include "pipeline/assets/gltf/gltf.h"
#include "pipeline/assets/light_map/light_map.h"
#include "pipeline/assets/mesh/mesh.h"
#include "pipeline/assets/results.h"

namespace lightcook::pipeline {
namespace {

using formats::Result;

/// Returns `bound` of the light map whose verification this is.
Result<Json> boundOf(const ActionRecord& verification) {
    LC_TRY(result, fromJson<VerifyResult>(verification.result, verification.id));
    return boundFiguresOf(result->verdict);
}

}  // namespace

Json boundFiguresOf(const Verdict& verdict) {
    Json bound = {{"passed", verdict.passed}};
    if (verdict.stages.empty()) return bound;
    const verify::StageError& total = verdict.stages.back();
    const auto add = [&](const char* key, const verify::ErrorFigures& figures) {
        bound[key] = {{"rel_rms", jsonOf(figures.relRms)}};
        if (figures.maxBound) bound[key]["max_bound"] = jsonOf(*figures.maxBound);
        if (figures.visible && figures.visible->bound) bound[key]["visible_bound"] = jsonOf(*figures.visible->bound);
    };
    add("diffuse", total.diffuse);
    add("specular", total.specular);
    return bound;
}

Result<Json> boundMapOf(const CookedAsset& asset, const std::string& workingColor, const std::string& shader) {
    const auto layout = formats::lightMapLayoutFromName(asset.layout);
    if (!layout)
        return formats::failure(formats::ErrorCode::Verification, asset.name,
                                fmt::format("found the layout \"{}\", expected a known one", asset.layout));
    Json textures = Json::array();
    for (const CookedTexture& texture : asset.textures) {
        Json& bound = textures.emplace_back(Json{{"role", texture.role},
                                                 {"uri", texture.file},
                                                 {"mimeType", "image/ktx2"},
                                                 {"array", texture.isArray.value_or(false)},
                                                 {"sampler", toJson(texture.sampler)}});
        if (texture.side) bound["side"] = *texture.side;
    }
    Json constants = asset.constants.value_or(Json::object());
    constants.erase(kIndexRuns);  // the vertices name the clusters
    std::vector<std::string> functions = decodeFunctions(formats::info(*layout));
    if (asset.detail)
        for (const std::string& function : decodeFunctions(formats::info(formats::kDetailLayout)))
            if (std::ranges::find(functions, function) == functions.end()) functions.push_back(function);
    Json map = {{"version", 1},
                {"name", asset.name},
                {"layout", asset.layout},
                {"width", asset.width},
                {"height", asset.height},
                {"quantity", asset.quantity.value_or("")},
                {"units", asset.units.value_or("")},
                {"phase", asset.phase.value_or("")},
                {"frame", asset.frame.value_or("")},
                {"color", workingColor},
                {"textures", std::move(textures)},
                {"constants", std::move(constants)},
                {"shader", {{"uri", shader}, {"functions", std::move(functions)}}}};
    if (asset.detail) map["detail"] = toJson(*asset.detail);
    if (asset.filter) map["filter"] = jsonOf(*asset.filter);
    if (hasClustersInMesh(asset)) map["basis"] = {{"attribute", formats::kBasisAttribute}};
    return map;
}

std::string gltfNameOf(const std::string& lightMap) {
    return lightMap + "_scene";
}

std::vector<std::string> decodeFunctions(const formats::LightMapLayoutInfo& layout) {
    if (layout.isLearned()) {
        std::vector<std::string> functions = {fmt::format("lcLightMapBasis{}From", layout.codeCount)};
        if (layout.residualCount() > 0) functions.emplace_back("lcLightMapBasisAddFrom");
        return functions;
    }
    std::string name = "lcLightMap";
    bool isFirst = true;
    for (const char c : layout.holdsLight() ? formats::nameOf(layout.family) : layout.name) {
        if (c != '-') name += isFirst ? static_cast<char>(std::toupper(static_cast<unsigned char>(c))) : c;
        isFirst = c == '-';
    }
    return {name};
}

Result<ActionOutcome> cookGltf(const ActionContext& context) {
    LC_TRY(parameters, parametersOf<GltfParameters>(context));
    LC_TRY(asset, upstreamAsset(context));
    LC_TRY(scene, loadLitMesh(context.action.inputs, parameters->description.places));
    std::optional<formats::ClusterMap> clusters;
    if (hasClustersInMesh(*asset)) {
        LC_TRY(map, clusterMapOf(*asset));
        clusters = std::move(*map);
    }
    LC_TRY(description, boundMapOf(*asset, parameters->description.colors.working, parameters->shader));
    LC_TRY(bound, boundOf(*context.upstream.at(1)));
    (*description)["bound"] = std::move(*bound);
    LC_TRY(source, openLightMap(context, parameters->description));
    LC_TRY(picture, flatPictureOf(**source, context));
    LC_TRY(png, formats::encodePng(picture->texels.view()));
    formats::GltfLightMap lightMap{asset->name, description->dump(), std::move(*png), picture->intensity, {}};
    if (parameters->probe) {
        LC_TRY(environment, environmentOf(*parameters->probe, parameters->repair, context));
        lightMap.environment = std::move(*environment);
    }
    const std::string file = gltfNameOf(asset->name) + ".glb";
    const std::filesystem::path plain = context.folder / (file + ".plain.glb");
    LC_CHECK(scene->writePlain(plain, clusters ? &*clusters : nullptr));
    const auto bytes = formats::bindLightMap(plain, context.folder / file, lightMap);
    std::error_code code;
    std::filesystem::remove(plain, code);
    if (!bytes) return tl::make_unexpected(bytes.error());
    return ActionOutcome{{{"bytes", *bytes}}, {file}};
}

}  // namespace lightcook::pipeline
