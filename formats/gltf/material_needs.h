// What one glTF material asks of the lighting.
#pragma once

#include "formats/gltf/gltf_document.h"
#include "formats/gltf_scene.h"

namespace lightcook::formats {

/// Throws what nlohmann::json throws where a member has the wrong type.
MaterialNeeds materialNeeds(const Json& material);

}  // namespace lightcook::formats
