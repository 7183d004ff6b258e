// lightcook info: the contents of a file or a cooked scene.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/error.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// Describes a texture, image, light map, mesh, scene file or output folder of cook.
formats::Result<Json> describeFile(const std::filesystem::path& file);

/// Returns the files of names and patterns ("*.ktx2", for shells that do not expand them), in the order of both. A pattern must match.
formats::Result<std::vector<std::filesystem::path>> expandPatterns(const std::vector<std::string>& names);

}  // namespace lightcook::pipeline
