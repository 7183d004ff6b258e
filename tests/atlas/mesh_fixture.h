// Triangles in the plane of a light map.
#pragma once

#include <cstddef>
#include <cstring>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "formats/chart_clusters.h"

namespace lightcook::atlas {

/// A mesh of light-map UVs alone.
inline formats::TriangleMesh meshOf(const std::vector<glm::vec2>& uvs, std::vector<std::uint32_t> indices) {
    formats::TriangleMesh mesh;
    formats::MeshAttribute& uv = mesh.attributes.emplace_back();
    uv.semantic = "TEXCOORD_1";
    uv.componentCount = 2;
    const std::span<const std::byte> bytes = std::as_bytes(std::span(uvs));
    uv.values.assign(bytes.begin(), bytes.end());
    mesh.indices = std::move(indices);
    return mesh;
}

/// Two triangles that fill a rectangle between two places [UV units].
inline formats::TriangleMesh rectangle(const glm::vec2& low, const glm::vec2& high) {
    return meshOf({low, {high.x, low.y}, {low.x, high.y}, high}, {0, 1, 2, 2, 1, 3});
}

}  // namespace lightcook::atlas
