#include "formats/chart_clusters.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/vec2.hpp>

#include "formats/disjoint_sets.h"
#include "formats/triangle_rows.h"

namespace lightcook::formats {
namespace {

constexpr int kBlock = kClusterBlock;
/// Filter weights below this are ignored.
constexpr double kLeastWeight = 1e-3;

int blocksOf(int texels) {
    return (texels + kBlock - 1) / kBlock;
}

/// Inside: the triangle holds the centre of the texel. Filtered: a bilinear filter inside the triangle gives the texel weight, that is, the
/// triangle comes closer to the centre than one texel on each axis.
enum class Touch { Inside, Filtered };

/// Calls visit(row, begin, end) for the texels of the map that a triangle touches, row by row.
template <class Visit>
void forEachRun(const Corners& corners, int width, int height, Touch touch, Visit visit) {
    const double reach = touch == Touch::Inside ? 0 : 1 - kLeastWeight;
    const auto [low, high] = std::minmax({corners[0].y, corners[1].y, corners[2].y});
    const int first = static_cast<int>(std::clamp(std::ceil(low - 0.5 - reach), 0.0, static_cast<double>(height)));
    const int last = static_cast<int>(std::clamp(std::floor(high - 0.5 + reach), -1.0, height - 1.0));
    for (int y = first; y <= last; ++y) {
        const Spread spread = spreadBetween(corners, y + 0.5 - reach, y + 0.5 + reach);
        if (!(spread.left <= spread.right)) continue;
        const int begin = static_cast<int>(std::clamp(std::ceil(spread.left - reach - 0.5), 0.0, static_cast<double>(width)));
        const int end = static_cast<int>(std::clamp(std::floor(spread.right + reach - 0.5), -1.0, width - 1.0)) + 1;
        if (begin < end) visit(y, begin, end);
    }
}

/// Returns the sets of vertices that triangles connect.
DisjointSets islandsOf(const TriangleMesh& mesh) {
    DisjointSets islands(mesh.vertexCount());
    for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
        islands.join(mesh.indices[i], mesh.indices[i + 1]);
        islands.join(mesh.indices[i], mesh.indices[i + 2]);
    }
    return islands;
}

constexpr int kNoCluster = -1;

Corners cornersOf(const TriangleMesh& mesh, const MeshAttribute& uv, std::size_t triangle, int width, int height) {
    Corners corners;
    for (std::size_t i = 0; i < 3; ++i) {
        const glm::dvec3 value = uv.at(mesh.indices[3 * triangle + i]);
        corners[i] = {value.x * width, value.y * height};
    }
    return corners;
}

/// Returns the texel that stands for a triangle without texel centres. Clamps as double: far outside the map a place does not fit an int.
glm::ivec2 texelAtCentroid(const Corners& corners, int width, int height) {
    const auto texelOf = [](double place, int size) { return static_cast<int>(std::clamp(std::floor(place), 0.0, size - 1.0)); };
    const glm::dvec2 centroid = (corners[0] + corners[1] + corners[2]) / 3.0;
    return {texelOf(centroid.x, width), texelOf(centroid.y, height)};
}

}  // namespace

tl::expected<ClusterMap, std::string> ClusterMap::fromRuns(int width, int height, std::span<const float> runs) {
    ClusterMap map{width, height, {}};
    const std::size_t blocks = static_cast<std::size_t>(blocksOf(width)) * static_cast<std::size_t>(blocksOf(height));
    const auto isWhole = [](float value, double largest) {
        return value >= 0 && static_cast<double>(value) <= largest && value == std::floor(value);
    };
    for (std::size_t i = 0; i + 1 < runs.size(); i += 2) {
        const std::size_t left = blocks - map.ofBlock.size();
        if (!isWhole(runs[i], 255) || !isWhole(runs[i + 1], static_cast<double>(left)))
            return tl::make_unexpected(
                fmt::format("found a run of {} blocks of cluster {}, expected at most {} of one below 256", runs[i + 1], runs[i], left));
        map.ofBlock.insert(map.ofBlock.end(), static_cast<std::size_t>(runs[i + 1]), static_cast<std::uint8_t>(runs[i]));
    }
    if (blocks == 0 || map.ofBlock.size() != blocks)
        return tl::make_unexpected(fmt::format("found the clusters of {} blocks, expected {}", map.ofBlock.size(), blocks));
    return map;
}

int ClusterMap::at(int x, int y) const {
    const int column = std::clamp(x, 0, width - 1) / kBlock, row = std::clamp(y, 0, height - 1) / kBlock;
    return ofBlock[static_cast<std::size_t>(row) * static_cast<std::size_t>(blocksOf(width)) + static_cast<std::size_t>(column)];
}

std::vector<IslandRun> islandRuns(std::span<const TriangleMesh* const> meshes, int width, int height) {
    std::vector<IslandRun> runs;
    int next = 0;
    for (const TriangleMesh* mesh : meshes) {
        const MeshAttribute* uv = mesh->find("TEXCOORD_1");
        if (uv == nullptr) continue;
        DisjointSets islands = islandsOf(*mesh);
        std::vector<int> nameOf(mesh->vertexCount(), kNoCluster);  // of each island, stored at its lowest vertex
        std::vector<bool> hasCentre(mesh->vertexCount(), false);
        for (std::size_t triangle = 0; triangle < mesh->triangleCount(); ++triangle) {
            const std::uint32_t island = islands.find(mesh->indices[3 * triangle]);
            if (nameOf[island] == kNoCluster) nameOf[island] = next++;
            const Corners corners = cornersOf(*mesh, *uv, triangle, width, height);
            forEachRun(corners, width, height, Touch::Inside, [&](int row, int begin, int end) {
                runs.push_back({nameOf[island], row, begin, end, true});
                hasCentre[island] = true;
            });
            forEachRun(corners, width, height, Touch::Filtered, [&](int row, int begin, int end) {
                runs.push_back({nameOf[island], row, begin, end, false});
            });
        }
        for (std::size_t triangle = 0; triangle < mesh->triangleCount(); ++triangle) {
            const std::uint32_t island = islands.find(mesh->indices[3 * triangle]);
            if (hasCentre[island]) continue;
            hasCentre[island] = true;
            const glm::ivec2 texel = texelAtCentroid(cornersOf(*mesh, *uv, triangle, width, height), width, height);
            runs.push_back({nameOf[island], texel.y, texel.x, texel.x + 1, true});
        }
    }
    return runs;
}

tl::expected<std::vector<std::uint8_t>, std::string> clustersOfVertices(const TriangleMesh& mesh, const ClusterMap& map) {
    const MeshAttribute* uv = mesh.find("TEXCOORD_1");
    if (uv == nullptr) return tl::make_unexpected(std::string("found no TEXCOORD_1, expected light-map UVs"));
    DisjointSets islands = islandsOf(mesh);
    std::vector<int> clusters(mesh.vertexCount(), kNoCluster);  // of each island, stored at its lowest vertex
    for (std::size_t triangle = 0; triangle < mesh.triangleCount(); ++triangle) {
        int& known = clusters[islands.find(mesh.indices[3 * triangle])];
        std::string conflict;
        forEachRun(
            cornersOf(mesh, *uv, triangle, map.width, map.height), map.width, map.height, Touch::Inside, [&](int y, int begin, int end) {
                for (int x = begin; x < end; ++x) {
                    const int found = map.at(x, y);
                    if (known == kNoCluster) known = found;
                    if (known != found && conflict.empty())
                        conflict = fmt::format("found cluster {} at texel ({}, {}) of triangle {}, expected {} as elsewhere in its island",
                                               found, x, y, triangle, known);
                }
            });
        if (!conflict.empty()) return tl::make_unexpected(conflict);
    }
    for (std::size_t triangle = 0; triangle < mesh.triangleCount(); ++triangle) {
        int& known = clusters[islands.find(mesh.indices[3 * triangle])];
        if (known != kNoCluster) continue;
        const glm::ivec2 texel = texelAtCentroid(cornersOf(mesh, *uv, triangle, map.width, map.height), map.width, map.height);
        known = map.at(texel.x, texel.y);
    }
    std::vector<std::uint8_t> result(mesh.vertexCount());
    for (std::uint32_t vertex = 0; vertex < result.size(); ++vertex)
        result[vertex] = static_cast<std::uint8_t>(std::max(clusters[islands.find(vertex)], 0));
    return result;
}

}  // namespace lightcook::formats
