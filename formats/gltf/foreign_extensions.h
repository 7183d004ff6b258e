// Extensions of a glTF document that are not read, and the indices that they may hold.
//
// A glTF is written with other accessors, buffer views and meshes than it had, and an extension may name any of them under any name:
// "values": 3 of EXT_structural_metadata is a buffer view, "visibility": 7 of EXT_mesh_primitive_edge_visibility an accessor. Which number
// is an index cannot be told, so each whole number of such an extension is taken for one of an accessor and of a buffer view: what has
// that number keeps number and content.
#pragma once

#include <cstdint>
#include <set>

#include "formats/gltf/gltf_document.h"

namespace lightcook::formats {

/// Returns the whole numbers below extensions that are not known to hold no index, anywhere in a document.
std::set<std::uint64_t> foreignIntegers(const Json& gltf);

/// Returns the accessors that extensions name or may name: these whole numbers, and those of EXT_mesh_gpu_instancing.
std::set<std::uint64_t> foreignAccessors(const Json& gltf);

/// Returns true if an extension of a primitive may depend on the order of its vertices or triangles.
bool hasOrderedExtension(const Json& primitive);

/// Gives the meshes that extensions name as "mesh" their new indices.
/// newIndexOf  the new index of each mesh, or kNoMesh
/// Throws GltfFault, with the name of the extension, if a mesh that it names is gone.
void renumberForeignMeshes(const GltfDocument& document, Json& gltf, const std::vector<std::size_t>& newIndexOf);

/// Fails if an extension that is not known names a buffer: all buffers become one. Throws GltfFault.
void checkNoForeignBuffers(const GltfDocument& document, const Json& gltf);

/// Place of a mesh that is left out.
inline constexpr std::size_t kNoMesh = SIZE_MAX;

}  // namespace lightcook::formats
