// Dependency files for build systems.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "formats/error.h"
#include "pipeline/graph/action.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

/// Returns a dependency file in makefile syntax: the manifest depends on the scene file and on every file that it names.
std::string depfileText(const Scene& scene, const std::filesystem::path& output, const std::vector<Action>& graph);

/// Returns a warning of the first path in a dependency file that Make reads otherwise than it stands: it has no escape that Ninja and CMake
/// read too. The file has such paths as they are, since these read most of them.
std::optional<formats::Error> warningForMake(const Scene& scene, const std::filesystem::path& output);

}  // namespace lightcook::pipeline
