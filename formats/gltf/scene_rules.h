// Rules of glTF 2.0 for what a scene says beside its geometry: nodes are trees, factors of materials lie in their ranges, references name
// what is there, and extensions that a reader must know are known. Sources: glTF 2.0 sections 3.5 (nodes), 3.9 (materials) and 3.12
// (extensions); KHR_materials_ior; KHR_materials_specular.
#pragma once

#include "formats/gltf/gltf_document.h"

namespace lightcook::formats {

/// Throws GltfFault at the first rule that is broken; the error names the node or the material.
void checkSceneRules(const GltfDocument& document);

}  // namespace lightcook::formats
