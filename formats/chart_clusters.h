// Assigns the basis of a learned light map to each vertex of a mesh. The light map stores the cluster (the index of its basis) for blocks
// of texels; a vertex shader needs it for vertices. The encoder gives one cluster to all texels that an island of a mesh covers, so that
// each vertex has exactly one.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "formats/gltf/triangle_mesh.h"

namespace lightcook::formats {

/// The vertex attribute of cooked meshes: one unsigned byte, the cluster.
inline constexpr const char* kBasisAttribute = "_LIGHTCOOK_BASIS";
/// Side of the blocks that have a cluster each [texels].
inline constexpr int kClusterBlock = 4;

/// Texels [begin, end) of a row that an island of a mesh reads. An island is a set of triangles connected by shared vertices.
struct IslandRun {
    int island;  ///< 0 and on, over all meshes
    int row, begin, end;
    bool isInside;  ///< true: the centres of the texels lie in a triangle; false: a bilinear filter inside a triangle reads them
};

/// Returns the texels of the light map that each island covers, by TEXCOORD_1. Meshes without TEXCOORD_1 are skipped. If an island holds no
/// texel centre, the texel under the centroid of its first triangle counts as inside. Time and size grow with the rows that triangles
/// cross.
std::vector<IslandRun> islandRuns(std::span<const TriangleMesh* const> meshes, int width, int height);

/// The cluster of each block of a light map.
struct ClusterMap {
    int width = 0, height = 0;          ///< [texels]
    std::vector<std::uint8_t> ofBlock;  ///< row by row

    /// Expands runs of blocks. Fails with a sentence if they do not fill the map.
    /// runs  pairs (cluster, number of blocks), as the manifest's `index_runs`
    static tl::expected<ClusterMap, std::string> fromRuns(int width, int height, std::span<const float> runs);
    /// Returns the cluster of the block that holds a texel; coordinates are clamped to the map.
    int at(int x, int y) const;
};

/// Returns the cluster of each vertex: that of the texels inside its island, as islandRuns() finds them; 0 for vertices that no triangle
/// uses. Fails with a sentence if the texels inside one island have different clusters, or if there is no TEXCOORD_1.
tl::expected<std::vector<std::uint8_t>, std::string> clustersOfVertices(const TriangleMesh& mesh, const ClusterMap& map);

}  // namespace lightcook::formats
