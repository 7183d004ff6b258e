// Triangle meshes in memory: attributes by their glTF names, and three indices a triangle.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec3.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "formats/error.h"

namespace lightcook::formats {

/// Component types, by their glTF numbers.
enum class ComponentType { Int8 = 5120, Uint8 = 5121, Int16 = 5122, Uint16 = 5123, Uint32 = 5125, Float32 = 5126 };
/// [bytes]; 0 for a number that is none of them.
std::size_t componentBytes(ComponentType type);

/// One attribute of every vertex, packed.
struct MeshAttribute {
    std::string semantic;  ///< "POSITION", "TEXCOORD_1"
    ComponentType componentType = ComponentType::Float32;
    int componentCount = 3;
    bool isNormalized = false;
    std::vector<std::byte> values;  ///< vertex by vertex, componentCount components each

    std::size_t bytesPerVertex() const { return componentBytes(componentType) * static_cast<std::size_t>(componentCount); }
    std::size_t vertexCount() const { return values.size() / bytesPerVertex(); }
    bool isFloat() const { return componentType == ComponentType::Float32; }
    /// Returns up to three components of a vertex (normalized integers as [0, 1] or [-1, 1]); missing ones are 0.
    glm::dvec3 at(std::size_t vertex) const;
    /// Returns one component, index < componentCount, of a vertex in the same way.
    double component(std::size_t vertex, int index) const;
    /// Returns one component as it is stored: a normalized integer as the integer.
    double stored(std::size_t vertex, int index) const;
};

struct TriangleMesh {
    std::vector<MeshAttribute> attributes;
    std::vector<std::uint32_t> indices;

    const MeshAttribute* find(std::string_view semantic) const;
    std::size_t triangleCount() const { return indices.size() / 3; }
    std::size_t vertexCount() const { return attributes.empty() ? 0 : attributes.front().vertexCount(); }
};

/// Returns the mesh with only the vertices that triangles use, in their old order.
TriangleMesh withoutUnusedVertices(const TriangleMesh& mesh);

/// The largest differences between matched corners.
struct TriangleMatch {
    double position = 0;       ///< distance [units of POSITION]
    double normalRadians = 0;  ///< 0 where either has no NORMAL
    double lightMapUv = 0;     ///< distance in TEXCOORD_1 [UV units]; 0 where either has none
};

/// Matches the triangles of `original` with those of `coded`, a lossy copy whose vertices, triangles and corners may come in another
/// order, and without the triangles that have two corners at one position. Winding is kept. Triangles pair one to one, closest pairs
/// first, among those whose centroids lie within 2 positionStep; distance counts position, normal and light-map UV of all corners.
/// positionStep  the lattice that positions of `coded` were rounded to; 0: they were not
/// Fails with a sentence when the counts differ or a triangle has no counterpart.
tl::expected<TriangleMatch, std::string> matchTriangles(const TriangleMesh& original, const TriangleMesh& coded, double positionStep);

}  // namespace lightcook::formats
