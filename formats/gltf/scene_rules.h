// Checks a glTF scene against the rules of glTF 2.0 that are not about geometry: nodes form trees, factors of materials lie in their
// ranges, references name entries that exist, and every required extension is one that we read or that leaves the geometry alone.
// Sources: glTF 2.0 sections 3.5 (nodes), 3.9 (materials) and 3.12 (extensions); KHR_materials_clearcoat; KHR_materials_ior;
// KHR_materials_pbrSpecularGlossiness; KHR_materials_specular.
#pragma once

#include "formats/gltf/gltf_document.h"

namespace lightcook::formats {

/// Throws GltfFault at the first rule that is broken; the error names the node or the material.
void checkSceneRules(const GltfDocument& document);

}  // namespace lightcook::formats
