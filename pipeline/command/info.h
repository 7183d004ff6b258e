// lightcook info: the contents of a file or a cooked scene.
#pragma once

#include <filesystem>

#include "formats/error.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// Describes a texture, image, light map, mesh, scene file or output folder of cook.
formats::Result<Json> describeFile(const std::filesystem::path& file);

}  // namespace lightcook::pipeline
