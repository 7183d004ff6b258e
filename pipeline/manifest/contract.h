// What a manifest promises to an engine beside the texels: conventions, samplers, sizes, the shader. Bytes can be right while these are
// wrong.
#pragma once

#include <filesystem>
#include <vector>

#include "formats/error.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// Everything in the manifest that the shader, the files or the sources contradict: conventions that the shader does not follow, samplers
/// that the verifier did not use, sizes that are not those of the files, constants inside textures that are not the manifest's, a shader
/// that is not the one that this program verifies by. manifest: one that readManifest took.
std::vector<formats::Error> checkContract(const std::filesystem::path& folder, const Json& manifest);

}  // namespace lightcook::pipeline
