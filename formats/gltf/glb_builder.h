// A glTF document written back as a GLB, with its triangles as Draco meshes or with a vertex attribute more.
#pragma once

#include <cstddef>
#include <glm/vec2.hpp>
#include <vector>

#include "formats/gltf/gltf_document.h"
#include "formats/gltf/primitive.h"
#include "formats/gltf_scene.h"

namespace lightcook::formats {

struct BuiltGlb {
    std::vector<std::byte> bytes;
    MeshSize size;
};

/// Changes that a written GLB has against its document.
struct GlbChanges {
    /// Quantization of the Draco meshes. If null, only primitives that are Draco streams already and get clusters are encoded again,
    /// without loss.
    const DracoOptions* draco = nullptr;
    const ClusterMap* clusters = nullptr;  ///< adds kBasisAttribute to the vertices of triangles
    /// Replaces TEXCOORD_1 of the triangle primitives, in the order of the file, and removes that of lines and points. Draco streams are
    /// written plain. Not beside draco.
    const std::vector<std::vector<glm::vec2>>* lightMapUvs = nullptr;
    /// Writes Draco streams plain. Images beside the scene are not embedded. Not beside other changes.
    bool isWithoutDraco = false;
};

/// Builds the GLB. Accessors and buffer views that nothing refers to any more are left out of the buffer; no other reference moves.
/// Throws GltfFault.
BuiltGlb buildGlb(const GltfDocument& document, const std::vector<Primitive>& primitives, const GlbChanges& changes);

}  // namespace lightcook::formats
