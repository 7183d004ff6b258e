// Triangle meshes to and from Draco's bit stream (edgebreaker). Draco's types end here.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "formats/gltf/triangle_mesh.h"

namespace lightcook::formats {

/// A lattice that float components are rounded to: 2^bits - 1 steps from origin to origin + range on each axis.
/// Of normals only the bits count: they are rounded on an octahedron.
struct Quantization {
    int bits = 0;
    std::vector<float> origin;
    float range = 1;
};

struct DracoMesh {
    std::vector<std::byte> bytes;
    std::vector<int> uniqueIds;  ///< Draco's id of each attribute, in the order of the mesh
    TriangleMesh decoded;        ///< what a reader will get
};

/// Attributes without quantization are kept bit for bit. Vertices that are alike in everything become one; triangles with two corners at
/// one position are dropped; the order of vertices and triangles changes.
/// quantization  for each attribute
/// Fails with Draco's own sentence, for one when every triangle is degenerate.
tl::expected<DracoMesh, std::string> encodeDraco(const TriangleMesh& mesh, std::span<const std::optional<Quantization>> quantization,
                                                 int speed);

/// What a glTF primitive says of an attribute in a Draco stream.
struct DracoAttribute {
    std::string semantic;
    int uniqueId = 0;
    ComponentType componentType = ComponentType::Float32;
    int componentCount = 3;
    bool isNormalized = false;
};
tl::expected<TriangleMesh, std::string> decodeDraco(std::span<const std::byte> bytes, std::span<const DracoAttribute> attributes);

/// The lattice step that positions in the stream were rounded to; 0 if they were not.
tl::expected<double, std::string> dracoPositionStep(std::span<const std::byte> bytes);

}  // namespace lightcook::formats
