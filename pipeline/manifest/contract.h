// The contract of a manifest with an engine, beside the texels: conventions, samplers, sizes, the shader.
#pragma once

#include <filesystem>
#include <vector>

#include "formats/error.h"
#include "pipeline/manifest/manifest.h"

namespace lightcook::pipeline {

/// Returns an error for each statement of the manifest that the shader, the files or the sources contradict: conventions that the shader
/// does not follow, samplers that the verifier does not use, sizes of files, constants inside textures, another shader than the program's
/// own.
std::vector<formats::Error> checkContract(const std::filesystem::path& folder, const Manifest& manifest);

}  // namespace lightcook::pipeline
