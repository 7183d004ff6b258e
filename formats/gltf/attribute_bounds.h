// Bounds of vertex attributes and the lattices that Draco rounds them to.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <map>
#include <string>
#include <vector>

#include "formats/gltf/draco_mesh.h"
#include "formats/gltf/primitive.h"

namespace lightcook::formats {

/// Bounds of one attribute. The primitives of a mesh share one, and so one lattice, so that no gaps open at their shared borders.
struct AttributeBounds {
    std::array<float, 3> low{std::numeric_limits<float>::max(), std::numeric_limits<float>::max(), std::numeric_limits<float>::max()};
    std::array<float, 3> high{std::numeric_limits<float>::lowest(), std::numeric_limits<float>::lowest(),
                              std::numeric_limits<float>::lowest()};

    void add(const MeshAttribute& attribute) {
        for (std::size_t vertex = 0; vertex < attribute.vertexCount(); ++vertex) {
            const glm::dvec3 value = attribute.at(vertex);
            for (std::size_t axis = 0; axis < 3; ++axis) {
                low[axis] = std::min(low[axis], static_cast<float>(value[static_cast<int>(axis)]));
                high[axis] = std::max(high[axis], static_cast<float>(value[static_cast<int>(axis)]));
            }
        }
    }
    /// Returns a lattice of 2^bits points an axis over these bounds; all axes have the longest extent.
    Quantization lattice(int bits, int componentCount) const {
        Quantization result{bits, {low.begin(), low.begin() + componentCount}, 0};
        for (std::size_t axis = 0; axis < static_cast<std::size_t>(componentCount); ++axis)
            result.range = std::max(result.range, high[axis] - low[axis]);
        if (!(result.range > 0)) result.range = 1;  // a single point; Draco wants some extent
        return result;
    }
};

/// Bounds of each attribute by its semantic, for each mesh.
using BoundsOfMeshes = std::map<std::size_t, std::map<std::string, AttributeBounds>>;

/// Returns the bounds of all positions, normals and UVs of the primitives that `isCounted` accepts.
template <class Predicate>
BoundsOfMeshes boundsOfMeshes(const std::vector<Primitive>& primitives, Predicate isCounted) {
    BoundsOfMeshes bounds;
    for (const Primitive& primitive : primitives)
        for (const MeshAttribute& attribute : primitive.geometry.attributes)
            if (isCounted(primitive) && mustBeFinite(attribute)) bounds[primitive.mesh][attribute.semantic].add(attribute);
    return bounds;
}

}  // namespace lightcook::formats
