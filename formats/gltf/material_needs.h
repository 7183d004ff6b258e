// Reads the lighting needs of a glTF material.
#pragma once

#include "formats/gltf/gltf_document.h"
#include "formats/gltf_scene.h"

namespace lightcook::formats {

/// Throws nlohmann::json::exception if a member has the wrong type.
MaterialNeeds materialNeeds(const Json& material);

}  // namespace lightcook::formats
