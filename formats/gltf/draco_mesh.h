// Triangle meshes to and from Draco's bit stream (edgebreaker). No type of Draco leaves draco_mesh.cpp.
#pragma once

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/gltf/triangle_mesh.h"

namespace lightcook::formats {

/// The lattice that float components are rounded to: 2^bits - 1 steps from origin to origin + range on each axis.
/// Normals use the bits only: they are rounded on an octahedron.
struct Quantization {
    int bits = 0;
    std::vector<float> origin;
    float range = 1;
};

struct DracoMesh {
    std::vector<std::byte> bytes;
    std::vector<int> uniqueIds;  ///< Draco's id of each attribute, in the order of the mesh
    TriangleMesh decoded;        ///< the mesh as a reader decodes it
};

/// Encodes a mesh. Attributes without quantization are kept bit for bit. Equal vertices are merged, triangles with two corners at one
/// position are dropped, and the order of vertices and triangles changes.
/// quantization  for each attribute
/// Fails with Draco's message, for example if every triangle is degenerate.
tl::expected<DracoMesh, std::string> encodeDraco(const TriangleMesh& mesh, std::span<const std::optional<Quantization>> quantization,
                                                 int speed);

/// An attribute of a Draco stream, as the glTF primitive declares it.
struct DracoAttribute {
    std::string semantic;
    int uniqueId = 0;
    ComponentType componentType = ComponentType::Float32;
    int componentCount = 3;
    bool isNormalized = false;
};
tl::expected<TriangleMesh, std::string> decodeDraco(std::span<const std::byte> bytes, std::span<const DracoAttribute> attributes);

/// The lattices that the values of a stream were rounded to.
struct DracoLattices {
    double positionStep = 0;           ///< 0 if positions were not rounded
    std::map<int, int> bitsOfId = {};  ///< bits of a component by the unique id of the attribute; absent: not rounded
};
tl::expected<DracoLattices, std::string> dracoLattices(std::span<const std::byte> bytes);

}  // namespace lightcook::formats
