// Dependency files for build systems.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/graph/action.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

/// Returns a dependency file in makefile syntax: the manifest depends on the scene file and on every file that it names.
std::string depfileText(const Scene& scene, const std::filesystem::path& output, const std::vector<Action>& graph);

}  // namespace lightcook::pipeline
