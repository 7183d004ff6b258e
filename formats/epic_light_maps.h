// The light maps of Unreal in a glTF file: extension EPIC_lightmap_textures of Unreal's own exporter. bakes/unreal.h decodes them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/error.h"

namespace lightcook::formats {

inline constexpr const char* kEpicExtension = "EPIC_lightmap_textures";

/// Returns true for the extensions .gltf and .glb.
bool isGltfFile(const std::filesystem::path& file);

/// Returns the names by which the scene key `image` chooses among the images of light maps, in the order of the file: the image's name, or
/// its index where it has none or shares it. Empty for a glTF without the extension.
Result<std::vector<std::string>> epicImageNames(const std::filesystem::path& file);

/// Returns the files beside a glTF that hold its buffers and the images of its light maps. Empty for a file that cannot be read: opening
/// the light map says why.
std::vector<std::filesystem::path> epicFilesBeside(const std::filesystem::path& file);

/// Fails if a node of the mesh of a light map in a glTF reads the light map elsewhere than at TEXCOORD_1 of the whole image: the cook and
/// its verification know no other UVs. Other light maps, and meshes without the extension, have no such nodes.
/// image  value of the scene key
Result<void> checkEpicUvs(const std::filesystem::path& lightMap, const std::filesystem::path& mesh, const std::string& image);

}  // namespace lightcook::formats
