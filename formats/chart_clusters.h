// Which basis of a learned light map each vertex of a mesh reads: the light map says it for blocks of texels, a vertex shader wants it for
// vertices. That there is one answer for each vertex is a promise that the light map's encoder keeps, told which texels a mesh holds
// together.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "formats/gltf/triangle_mesh.h"

namespace lightcook::formats {

/// The vertex attribute of cooked meshes: one unsigned byte, the cluster.
inline constexpr const char* kBasisAttribute = "_LIGHTCOOK_BASIS";
/// Texels of a side of the blocks that clusters are given to.
inline constexpr int kClusterBlock = 4;

/// Texels [begin, end) of a row that an island of a mesh reads. An island is triangles that share vertices.
struct IslandRun {
    int island;  ///< 0 and on, over all meshes
    int row, begin, end;
    bool isInside;  ///< their centres lie in one of its triangles; else points in it are filtered from them
};

/// Where the islands of meshes lie on their light map, by TEXCOORD_1; meshes without are passed over. Of an island that holds no texel
/// centre, the texel under its first triangle's centroid counts as inside. Time and size go with triangles and the rows that they cross.
std::vector<IslandRun> islandRuns(std::span<const TriangleMesh* const> meshes, int width, int height);

/// The cluster of each block of a light map.
struct ClusterMap {
    int width = 0, height = 0;          ///< [texels]
    std::vector<std::uint8_t> ofBlock;  ///< row by row

    /// runs  pairs (cluster, how many blocks), as the manifest's `index_runs`. Fails with a sentence where they do not fill the map.
    static tl::expected<ClusterMap, std::string> fromRuns(int width, int height, std::span<const float> runs);
    /// Of the block that holds a texel; texels beyond the map take the nearest.
    int at(int x, int y) const;
};

/// The cluster of each vertex: that of the texels inside its island, as islandRuns has them. Vertices that no triangle uses take 0.
/// Fails with a sentence where texels inside one island have different clusters, or without TEXCOORD_1.
tl::expected<std::vector<std::uint8_t>, std::string> clustersOfVertices(const TriangleMesh& mesh, const ClusterMap& map);

}  // namespace lightcook::formats
