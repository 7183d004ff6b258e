// Meshes as inputs of actions.
#pragma once

#include <filesystem>
#include <map>
#include <string>

#include "formats/gltf_scene.h"

namespace lightcook::pipeline {

/// Returns a mesh and the files beside it as inputs: roles `role`, `role`_file0, `role`_file1, ...
std::map<std::string, std::filesystem::path> meshInputs(const std::string& role, const std::filesystem::path& mesh,
                                                        formats::GltfFiles which = formats::GltfFiles::All);

}  // namespace lightcook::pipeline
