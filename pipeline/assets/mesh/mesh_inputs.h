// Meshes as inputs of actions.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "formats/gltf_scene.h"

namespace lightcook::pipeline {

/// Returns a mesh and the files beside it as inputs: roles `role`, `role`_file0, `role`_file1, ..., and `role`_lmbake.
/// lmbake  empty: there is none
std::map<std::string, std::filesystem::path> meshInputs(const std::string& role, const std::filesystem::path& mesh,
                                                        const std::filesystem::path& lmbake,
                                                        formats::GltfFiles which = formats::GltfFiles::All);
/// Returns the lmbake of such a mesh; empty: there is none.
std::filesystem::path lmbakeOf(const std::map<std::string, std::filesystem::path>& inputs, const std::string& role);
/// Loads such a mesh, with its light-map UVs where the lmbake or the places of a light map put them.
formats::Result<formats::GltfScene> loadMesh(const std::map<std::string, std::filesystem::path>& inputs, const std::string& role,
                                             const std::vector<formats::NodePlace>& places);

/// Returns "3 nodes in the dark: 'a', 'b', 'c'", with the first names of many.
/// what  "nodes in the dark"
std::string countOfNames(const std::vector<std::string>& names, std::string_view what);

}  // namespace lightcook::pipeline
