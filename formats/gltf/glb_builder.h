// A glTF document written back as a GLB, with its triangles as Draco meshes or with a vertex attribute more.
#pragma once

#include <cstddef>
#include <vector>

#include "formats/gltf/gltf_document.h"
#include "formats/gltf/primitive.h"
#include "formats/gltf_scene.h"

namespace lightcook::formats {

struct BuiltGlb {
    std::vector<std::byte> bytes;
    MeshSize size;
};

/// Builds the GLB. Accessors and buffer views that nothing refers to any more are left out of the buffer; no other reference moves.
/// clusters  adds kBasisAttribute to the vertices of triangles; may be null
/// options   quantization of the Draco meshes. If null, only primitives that are Draco streams already and gain an attribute are encoded
///           again, without loss.
/// Throws GltfFault.
BuiltGlb buildGlb(const GltfDocument& document, const std::vector<Primitive>& primitives, const ClusterMap* clusters,
                  const DracoOptions* options);

}  // namespace lightcook::formats
