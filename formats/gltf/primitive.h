// The primitives of a glTF document, read and checked.
#pragma once

#include <fmt/format.h>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "formats/gltf/gltf_document.h"
#include "formats/gltf/triangle_mesh.h"

namespace lightcook::formats {

inline constexpr const char* kDracoExtension = "KHR_draco_mesh_compression";

/// One primitive of one mesh.
struct Primitive {
    std::size_t mesh = 0, index = 0;
    TriangleMesh geometry;        ///< for triangles, only the vertices that they use; no indices for points and lines
    std::size_t vertexCount = 0;  ///< number of vertices in the accessors, which other primitives may share
    bool isTriangles = false;     ///< triangles, or a strip or fan of them, whose indices are those of single triangles here
    /// Triangles without morph targets and without an extension that may depend on the order of vertices, which must be kept.
    bool canCompress = false;
    std::optional<std::uint64_t> dracoView;
    std::map<std::string, int> dracoIds;      ///< unique ids of the attributes in the Draco stream, by semantic
    std::vector<std::uint32_t> usedVertices;  ///< for triangles, the index in the accessors of each vertex of the geometry

    std::string place() const { return fmt::format("mesh {}, primitive {}", mesh, index); }
};

/// Returns the meshes, by their indices, that have triangles with light-map UVs (light_map_uvs.h). Reads no buffers.
std::set<std::uint64_t> meshesWithLightMapUvs(const GltfDocument& document);
/// Returns the meshes, by their indices, that have triangles without light-map UVs. Reads no buffers.
std::set<std::uint64_t> meshesWithoutLightMapUvs(const GltfDocument& document);

/// Returns the first of TEXCOORD_2, TEXCOORD_3, ... that no triangle primitive has.
std::string freeUv(const std::vector<Primitive>& primitives);

/// Returns true for attributes whose values are checked, and which Draco may quantize: float positions, normals and UVs.
bool mustBeFinite(const MeshAttribute& attribute);

/// Reads every primitive of every mesh, in the order of the file. Accessors that several primitives share are read once.
/// Throws GltfFault for missing positions, vertex counts that differ, indices out of range and values that are not finite.
std::vector<Primitive> readPrimitives(const GltfDocument& document);

}  // namespace lightcook::formats
