// Reads the lighting needs of a glTF material.
#pragma once

#include <string>
#include <vector>

#include "formats/gltf/gltf_document.h"
#include "formats/gltf_scene.h"

namespace lightcook::formats {

/// Returns the union of the specular lobes of a material. Throws nlohmann::json::exception if a member has the wrong type.
MaterialNeeds materialNeeds(const Json& material);

/// Returns the names of a material's extensions that may change its reflection and that materialNeeds() does not read.
std::vector<std::string> unreadExtensions(const Json& material);

}  // namespace lightcook::formats
