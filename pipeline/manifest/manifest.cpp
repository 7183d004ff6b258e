#include "pipeline/manifest/manifest.h"

#include <fmt/format.h>

#include <set>

#include "formats/light_map_layout.h"
#include "pipeline/graph/files.h"
#include "pipeline/graph/version.h"
#include "pipeline/manifest/cooked_folder.h"
#include "shaders/include.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Result;

/// Reads a manifest. Members that a cook action leaves open, and the manifest fills in, have to be there; two assets of one name may not.
Manifest readFinished(const JsonPlace& root) {
    Manifest manifest;
    readValue(root, manifest, {});
    std::set<std::string> names;
    for (std::size_t i = 0; i < manifest.assets.size(); ++i) {
        const JsonPlace asset = root["assets"].element(i);
        const AssetKind kind = manifest.assets[i].kind;
        if (!names.insert(manifest.assets[i].name).second) asset["name"].fail("a name that no other asset has");
        for (std::size_t texture = 0; texture < manifest.assets[i].textures.size(); ++texture)
            asset["textures"].element(texture)["digest"].text();
        if (manifest.assets[i].file) asset["digest"].text();
        const JsonPlace files = asset["source"]["files"];
        files.object();
        if (kind != AssetKind::Lut) files["source"].object();
        if (kind == AssetKind::Mesh) {
            files["mesh"].object();
            asset["file"].text();
        }
    }
    return manifest;
}

}  // namespace

Result<CookedAsset> manifestAsset(const ActionRecord& cooked, const std::map<std::string, std::filesystem::path>& sources,
                                  const std::filesystem::path& sceneDirectory, DigestMemo& digests) {
    LC_TRY(asset, fromJson<CookedAsset>(cooked.result.value("asset", Json()), cooked.id));
    const auto digestOf = [&](const std::string& file) {
        for (const FileRecord& each : cooked.files)
            if (each.name == file) return each.digest;
        return std::string();
    };
    for (CookedTexture& texture : asset->textures) texture.digest = digestOf(texture.file);
    if (asset->file) asset->digest = digestOf(*asset->file);
    auto& files = asset->source.files.emplace();
    for (const auto& [role, path] : sources)
        files[role] = {std::filesystem::proximate(path, sceneDirectory.empty() ? "." : sceneDirectory).generic_string(),
                       digests.ofInputAsRead(path)};
    return asset;
}

Manifest makeManifest(const Scene& scene, const std::filesystem::path& outputFolder, std::vector<CookedAsset> assets,
                      std::vector<GltfFile> gltf, const std::string& shaderDigest) {
    Manifest manifest;
    manifest.scene = scene.name;
    manifest.tool = {kToolName, kToolVersion};
    manifest.sceneDirectory = std::filesystem::proximate(scene.directory.empty() ? "." : scene.directory, outputFolder).generic_string();
    if (!scene.file.empty()) manifest.sceneFile = scene.file.filename().string();
    manifest.target = formats::info(scene.output.target).name;
    manifest.workingColor = scene.colors.working;
    manifest.lobe = scene.lobe;
    manifest.up = scene.up;
    manifest.gltf = std::move(gltf);
    manifest.shader = {kShaderName, shaderDigest};
    manifest.assets = std::move(assets);
    return manifest;
}

Result<Manifest> loadManifest(const std::filesystem::path& folder) {
    const std::filesystem::path file = folder / kManifestName;
    const auto text = readFile(file);
    if (!text) {
        std::error_code code;
        if (std::filesystem::is_regular_file(folder, code))
            return failure(ErrorCode::FileUnreadable, folder, "found a file, expected the output folder of `lightcook cook`");
        const bool isFolder = std::filesystem::is_directory(folder, code);
        return failure(ErrorCode::FileUnreadable, file,
                       fmt::format("found no {}, expected {}", isFolder ? "manifest" : "such folder", expectedCookedFolder(folder)));
    }
    const Json json = parseJson(*text);
    if (json.is_discarded() || !json.is_object() || !json.contains("assets"))
        return failure(ErrorCode::FileUnreadable, file, "found no manifest in it, expected what `lightcook cook` writes");
    if (json.contains("schema") && json["schema"].is_number_integer() && json["schema"] != 1)
        return failure(
            ErrorCode::FormatUnsupported, file,
            fmt::format("found schema {}, expected 1: another version of lightcook wrote it; cook the scene again", json["schema"].dump()));
    return checkedJson(json, file, readFinished);
}

Result<Json> readManifest(const std::filesystem::path& folder) {
    LC_TRY(manifest, loadManifest(folder));
    return toJson(*manifest);
}

std::string shaderTextOf(const std::vector<CookedAsset>& assets, lighting::SpecularLobe lobe) {
    std::vector<std::string> layouts;
    for (const CookedAsset& asset : assets)
        if (asset.kind == AssetKind::LightMap) {
            layouts.push_back(asset.layout);
            if (asset.detail) layouts.push_back(asset.detail->layout);
        }
    const bool isGgx = lobe == lighting::SpecularLobe::Ggx;
    return shaders::shaderInclude(formats::lightMapFamilies(layouts), isGgx ? shaders::Distribution::Ggx : shaders::Distribution::Beckmann);
}

std::vector<FileRecord> filesOf(const CookedAsset& asset) {
    std::vector<FileRecord> files;
    if (asset.file) files.push_back({*asset.file, asset.digest.value_or(""), 0});
    for (const CookedTexture& texture : asset.textures) files.push_back({texture.file, texture.digest, 0});
    return files;
}

std::vector<FileRecord> filesOf(const Manifest& manifest) {
    std::vector<FileRecord> files = {{manifest.shader.file, manifest.shader.digest, 0}};
    for (const CookedAsset& asset : manifest.assets) std::ranges::copy(filesOf(asset), std::back_inserter(files));
    for (const GltfFile& gltf : manifest.gltf) files.push_back({gltf.file, gltf.digest, 0});
    return files;
}

}  // namespace lightcook::pipeline
