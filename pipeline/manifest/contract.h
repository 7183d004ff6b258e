// What a manifest says of its files beside their texels: samplers, sizes, the shader, and the copies of it inside textures and glTF files.
#pragma once

#include <filesystem>
#include <vector>

#include "formats/error.h"
#include "pipeline/manifest/manifest.h"

namespace lightcook::pipeline {

/// Returns an error for each statement of the manifest that the files contradict: samplers that the verifier does not use, sizes, constants
/// inside textures and glTF files, another shader than the program's own.
std::vector<formats::Error> checkContract(const std::filesystem::path& folder, const Manifest& manifest);

}  // namespace lightcook::pipeline
