#include "pipeline/manifest/manifest.h"

#include <fmt/format.h>

#include "pipeline/graph/files.h"
#include "pipeline/graph/version.h"
#include "pipeline/manifest/json_shape.h"

namespace lightcook::pipeline {

using formats::ErrorCode;
using formats::failure;
using formats::Result;

Json manifestAsset(const Action& cook, const Action& verify, const ActionRecord& cooked, const std::filesystem::path& sceneDirectory,
                   DigestMemo& digests) {
    Json asset = cooked.result.at("asset");
    const auto record = [&](const std::string& file) {
        for (const FileRecord& each : cooked.files)
            if (each.name == file) return each;
        return FileRecord{};
    };
    for (Json& texture : asset["textures"]) texture["digest"] = record(texture.at("file").get<std::string>()).digest;
    if (asset.contains("file")) asset["digest"] = record(asset.at("file").get<std::string>()).digest;
    std::map<std::string, std::filesystem::path> sources = verify.inputs;
    sources.insert(cook.inputs.begin(), cook.inputs.end());
    Json files = Json::object();
    for (const auto& [role, path] : sources)
        files[role] = {{"file", std::filesystem::proximate(path, sceneDirectory.empty() ? "." : sceneDirectory).generic_string()},
                       {"digest", digests.of(path).value_or("")}};
    asset["source"]["files"] = files;
    asset["verify"] = verify.parameters;
    return asset;
}

Json makeManifest(const Scene& scene, const std::filesystem::path& outputFolder, std::vector<Json> assets,
                  const std::string& shaderDigest) {
    Json manifest = {
        {"schema", 1},
        {"scene", scene.name},
        {"tool", {{"name", kToolName}, {"version", kToolVersion}}},
        {"scene_directory", std::filesystem::proximate(scene.directory.empty() ? "." : scene.directory, outputFolder).generic_string()},
        {"target", std::string(formats::info(scene.output.target).name)},
        {"color", {{"working", scene.colors.working}}},
        {"shader", {{"file", kShaderName}, {"digest", shaderDigest}}},
        {"assets", Json::array()}};
    for (Json& asset : assets) manifest["assets"].push_back(std::move(asset));
    return manifest;
}

Result<Json> readManifest(const std::filesystem::path& folder) {
    const std::filesystem::path file = folder / kManifestName;
    const auto text = readFile(file);
    if (!text) {
        std::error_code code;
        const bool isFolder = std::filesystem::is_directory(folder, code);
        return failure(ErrorCode::FileUnreadable, file.string(),
                       isFolder ? "found no manifest, expected the output folder of `lightcook cook`"
                                : "found no such folder, expected the output folder of `lightcook cook`");
    }
    Json manifest = parseJson(*text);
    if (manifest.is_discarded() || !manifest.is_object() || !manifest.contains("assets"))
        return failure(ErrorCode::FileUnreadable, file.string(), "found no manifest in it, expected what `lightcook cook` writes");
    if (manifest.contains("schema") && manifest["schema"].is_number_integer() && manifest["schema"] != 1)
        return failure(ErrorCode::FormatUnsupported, file.string(), fmt::format("found schema {}, expected 1", manifest["schema"].dump()));
    if (auto shaped = checkManifest(manifest, file.string()); !shaped) return tl::make_unexpected(shaped.error());
    return manifest;
}

std::vector<FileRecord> filesOf(const Json& manifest) {
    std::vector<FileRecord> files;
    const auto add = [&](const Json& entry) {
        if (entry.contains("file") && entry.contains("digest"))
            files.push_back({entry["file"].get<std::string>(), entry["digest"].get<std::string>(), 0});
    };
    if (manifest.contains("shader")) add(manifest["shader"]);
    for (const Json& asset : manifest.at("assets")) {
        add(asset);
        if (asset.contains("textures"))
            for (const Json& texture : asset["textures"]) add(texture);
    }
    return files;
}

}  // namespace lightcook::pipeline
