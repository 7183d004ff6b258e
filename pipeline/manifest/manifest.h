// cooked.json: what an engine, and the verifier, need to know of a cooked scene.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/cook/plan.h"
#include "pipeline/graph/action.h"
#include "pipeline/graph/executor.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

inline constexpr const char* kManifestName = "cooked.json";
inline constexpr const char* kShaderName = "lightcook.glsl";

/// The entry of one asset: what its cook action said, the digests of its files and sources, and how it is verified.
/// sceneDirectory   sources are named relative to it, so that a manifest means the same on another machine
Json manifestAsset(const Action& cook, const Action& verify, const ActionRecord& cooked, const std::filesystem::path& sceneDirectory,
                   DigestMemo& digests);

/// directoryFromOutput  the scene's folder as seen from the output folder
Json makeManifest(const Scene& scene, const std::filesystem::path& outputFolder, std::vector<Json> assets, const std::string& shaderDigest);

formats::Result<Json> readManifest(const std::filesystem::path& folder);
/// Every file that the manifest names, relative to its folder.
std::vector<FileRecord> filesOf(const Json& manifest);

}  // namespace lightcook::pipeline
