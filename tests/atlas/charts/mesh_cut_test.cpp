// Meshes cut along tiles, checked by areas, places and edges of the triangles that come out.
#include "atlas/mesh_cut.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <map>
#include <random>
#include <string>

namespace lightcook::atlas {
namespace {

using formats::CutMesh;
using formats::MeshAttribute;
using formats::TriangleMesh;

constexpr int kMapSide = 256;
constexpr int kTile = 16;
constexpr std::uint8_t kMaps = 3;

MeshAttribute attributeOf(const std::string& semantic, int components, const std::vector<float>& values) {
    MeshAttribute attribute;
    attribute.semantic = semantic;
    attribute.componentCount = components;
    attribute.values.resize(values.size() * sizeof(float));
    std::memcpy(attribute.values.data(), values.data(), attribute.values.size());
    return attribute;
}

/// A face of a cube of n x n squares, with a chart of its own that is turned in the map.
/// seed  of its place in the map
TriangleMesh face(int index, int n, std::uint32_t seed) {
    std::mt19937 random(seed);
    const auto fraction = [&] { return static_cast<float>(random()) * 0x1p-32f; };
    const float angle = fraction(), reach = 40 + 10 * fraction();
    const glm::vec2 u(reach * std::cos(angle), reach * std::sin(angle)), v(-0.5f * u.y, 0.5f * u.x);
    const int column = index % 3, row = index / 3;
    const glm::vec2 origin(40.3f + 80.0f * static_cast<float>(column), 10.7f + 120.0f * static_cast<float>(row));
    std::vector<float> positions, uvs;
    std::vector<std::uint32_t> indices;
    for (int y = 0; y <= n; ++y)
        for (int x = 0; x <= n; ++x) {
            const float a = static_cast<float>(x) / static_cast<float>(n), b = static_cast<float>(y) / static_cast<float>(n);
            const float side = index % 2 == 0 ? 0.0f : 1.0f;
            const bool isTurned = index % 2 == 0;  // so that every face is seen from outside
            const float first = isTurned ? b : a, second = isTurned ? a : b;
            std::array<float, 3> at{};
            at[static_cast<std::size_t>(index / 2)] = side;
            at[static_cast<std::size_t>((index / 2 + 1) % 3)] = first;
            at[static_cast<std::size_t>((index / 2 + 2) % 3)] = second;
            positions.insert(positions.end(), at.begin(), at.end());
            const glm::vec2 uv = (origin + a * u + b * v) / static_cast<float>(kMapSide);
            uvs.insert(uvs.end(), {uv.x, uv.y});
        }
    for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x) {
            const auto at = static_cast<std::uint32_t>(y * (n + 1) + x), below = at + static_cast<std::uint32_t>(n + 1);
            indices.insert(indices.end(), {at, at + 1, below, below, at + 1, below + 1});
        }
    TriangleMesh mesh;
    mesh.attributes = {attributeOf("POSITION", 3, positions), attributeOf("TEXCOORD_1", 2, uvs)};
    mesh.indices = indices;
    return mesh;
}

/// A cube, of one mesh a face.
struct Cube {
    std::vector<TriangleMesh> meshes;
    std::vector<const TriangleMesh*> pointers;
    ChartSet charts;
    Tiles tiles;

    static Cube of(int n) {
        std::vector<TriangleMesh> meshes;
        for (int i = 0; i < 6; ++i) meshes.push_back(face(i, n, static_cast<std::uint32_t>(100 * n + i)));
        std::vector<const TriangleMesh*> pointers;
        for (const TriangleMesh& mesh : meshes) pointers.push_back(&mesh);
        auto charts = findCharts(pointers, std::vector<formats::Subject>(6, "cube"), kMapSide, kMapSide);
        EXPECT_TRUE(charts && charts->charts.size() == 6u);
        Tiles tiles(boxesOf(charts->charts), kTile);
        return {std::move(meshes), std::move(pointers), std::move(*charts), std::move(tiles)};
    }
    std::vector<CutMesh> cut(const std::vector<std::uint8_t>& mapOf, std::uint8_t map) const {
        return cutMeshes(pointers, {charts, tiles, glm::ivec2(kMapSide), mapOf}, map);
    }
    /// Returns the triangles of the tiles of all maps.
    std::vector<std::vector<CutMesh>> cutAll(const std::vector<std::uint8_t>& mapOf) const {
        std::vector<std::vector<CutMesh>> parts;
        for (std::uint8_t map = 0; map < kMaps; ++map) parts.push_back(cut(mapOf, map));
        return parts;
    }
    std::vector<std::uint8_t> randomMaps(std::uint32_t seed) const {
        std::mt19937 random(seed);
        std::vector<std::uint8_t> mapOf;
        for (int i = 0; i < tiles.count(); ++i) mapOf.push_back(static_cast<std::uint8_t>(random() % kMaps));
        return mapOf;
    }
    std::vector<std::uint8_t> allIn(std::uint8_t map) const {
        return std::vector<std::uint8_t>(static_cast<std::size_t>(tiles.count()), map);
    }
};

glm::dvec3 valueAt(const MeshAttribute& attribute, const formats::CutVertex& vertex) {
    glm::dvec3 sum(0);
    for (std::size_t i = 0; i < 3; ++i) sum += vertex.weight[i] * attribute.at(vertex.from[i]);
    return sum;
}

/// Calls visit(mesh, corners) for each triangle, with values of an attribute at its corners.
template <class Visit>
void forEachTriangle(const Cube& cube, const std::vector<CutMesh>& cut, const char* semantic, Visit visit) {
    for (std::size_t mesh = 0; mesh < cut.size(); ++mesh)
        for (std::size_t i = 0; i < cut[mesh].indices.size(); i += 3) {
            std::array<glm::dvec3, 3> corners;
            for (std::size_t corner = 0; corner < 3; ++corner)
                corners[corner] = valueAt(*cube.meshes[mesh].find(semantic), cut[mesh].vertices[cut[mesh].indices[i + corner]]);
            visit(mesh, corners);
        }
}

double areaOf(const Cube& cube, const std::vector<CutMesh>& cut, const char* semantic) {
    double area = 0;
    forEachTriangle(cube, cut, semantic, [&](std::size_t, const std::array<glm::dvec3, 3>& at) {
        area += glm::length(glm::cross(at[1] - at[0], at[2] - at[0])) / 2;
    });
    return area;
}

TEST(MeshCut, AllTilesAreTheMeshAsItWas) {
    const Cube cube = Cube::of(5);
    const auto cut = cube.cut(cube.allIn(1), 1);
    for (std::size_t mesh = 0; mesh < 6; ++mesh) {
        EXPECT_EQ(cut[mesh].indices, cube.meshes[mesh].indices);
        ASSERT_EQ(cut[mesh].vertices.size(), cube.meshes[mesh].vertexCount());
        for (std::size_t i = 0; i < cut[mesh].vertices.size(); ++i) {
            EXPECT_EQ(cut[mesh].vertices[i].from[0], i);
            EXPECT_EQ(cut[mesh].vertices[i].weight, (std::array<double, 3>{1, 0, 0}));
        }
    }
    for (const CutMesh& none : cube.cut(cube.allIn(0), 1)) {
        EXPECT_TRUE(none.indices.empty());
        EXPECT_TRUE(none.vertices.empty());
    }
}

TEST(MeshCut, AllPartsTogetherHaveTheWholeArea) {
    for (const int n : {1, 2, 7}) {
        const Cube cube = Cube::of(n);
        const auto whole = cube.cut(cube.allIn(1), 1);
        for (std::uint32_t seed = 0; seed < 8; ++seed) {
            double area = 0, uvArea = 0;
            for (const auto& part : cube.cutAll(cube.randomMaps(seed))) {
                EXPECT_GT(areaOf(cube, part, "POSITION"), 0.5);
                area += areaOf(cube, part, "POSITION");
                uvArea += areaOf(cube, part, "TEXCOORD_1");
            }
            EXPECT_NEAR(area, 6, 1e-6);
            EXPECT_NEAR(uvArea, areaOf(cube, whole, "TEXCOORD_1"), 1e-8);
        }
    }
}

TEST(MeshCut, TrianglesLieInTilesOfTheirPart) {
    constexpr double kOff = 1.0 / 512;  // [texels]
    for (const int n : {1, 3}) {
        const Cube cube = Cube::of(n);
        const auto mapOf = cube.randomMaps(7);
        forEachTriangle(cube, cube.cut(mapOf, 1), "TEXCOORD_1", [&](std::size_t mesh, const std::array<glm::dvec3, 3>& corners) {
            const std::size_t chart = cube.charts.ofVertex[mesh].front();
            std::array<glm::dvec2, 3> at;
            for (std::size_t i = 0; i < 3; ++i) at[i] = glm::dvec2(corners[i]) * double(kMapSide) - 0.5;
            // Places all over the triangle, drawn in by as much as a corner may lie beyond a line.
            for (int i = 0; i <= 8; ++i)
                for (int j = 0; i + j <= 8; ++j) {
                    const glm::dvec2 middle = (at[0] + at[1] + at[2]) / 3.0;
                    glm::dvec2 place = (at[0] * double(i) + at[1] * double(j) + at[2] * double(8 - i - j)) / 8.0;
                    const double far = glm::length(middle - place);
                    if (far > 0) place += (middle - place) * std::min(1.0, 2 * kOff / far);
                    const glm::ivec2 low(glm::floor(place - kOff - kLineOffset)), high(glm::floor(place + kOff));
                    bool isInside = false;
                    for (const glm::ivec2 quad : {low, high, glm::ivec2(low.x, high.y), glm::ivec2(high.x, low.y)})
                        isInside = isInside || mapOf[static_cast<std::size_t>(cube.tiles.ofQuad(chart, quad))] == 1;
                    ASSERT_TRUE(isInside) << place.x << " " << place.y;
                }
        });
    }
}

/// The edges of a closed mesh pass each triangle in both directions. A vertex that only one side of an edge had would break that.
TEST(MeshCut, NoGapsOpen) {
    using Place = std::array<float, 3>;
    for (const int n : {1, 2, 5}) {
        const Cube cube = Cube::of(n);
        for (std::uint32_t seed = 0; seed < 8; ++seed) {
            std::map<std::pair<Place, Place>, int> edges;
            std::size_t triangles = 0;
            for (const auto& cut : cube.cutAll(cube.randomMaps(seed)))
                forEachTriangle(cube, cut, "POSITION", [&](std::size_t, const std::array<glm::dvec3, 3>& corners) {
                    std::array<Place, 3> places;
                    for (std::size_t i = 0; i < 3; ++i)
                        places[i] = {static_cast<float>(corners[i].x), static_cast<float>(corners[i].y), static_cast<float>(corners[i].z)};
                    for (std::size_t i = 0; i < 3; ++i) ++edges[{places[i], places[(i + 1) % 3]}];
                    ++triangles;
                });
            EXPECT_GT(triangles, static_cast<std::size_t>(12 * n * n)) << "something was cut";
            for (const auto& [edge, count] : edges) {
                const auto back = edges.find({edge.second, edge.first});
                ASSERT_TRUE(back != edges.end() && back->second == count)
                    << n << " " << seed << ": " << edge.first[0] << " " << edge.first[1] << " " << edge.first[2];
            }
        }
    }
}

/// A rectangle of two triangles, with its light-map UVs between two places [texels; integers are centres].
TriangleMesh texelRectangle(const glm::vec2& low, const glm::vec2& high) {
    const glm::vec2 a = (low + 0.5f) / float(kMapSide), b = (high + 0.5f) / float(kMapSide);
    TriangleMesh mesh;
    mesh.attributes = {attributeOf("POSITION", 3, {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0}),
                       attributeOf("TEXCOORD_1", 2, {a.x, a.y, b.x, a.y, b.x, b.y, a.x, b.y})};
    mesh.indices = {0, 1, 2, 0, 2, 3};
    return mesh;
}

ChartSet cutChartsOf(const TriangleMesh& mesh) {
    const std::vector<const TriangleMesh*> meshes = {&mesh};
    auto charts = findCharts(meshes, std::vector<formats::Subject>(1, "rectangle"), kMapSide, kMapSide);
    EXPECT_TRUE(charts);
    return std::move(*charts);
}

/// Returns the chart of the tiles of map 1.
Chart chartOf(const TriangleMesh& mesh, const ChartSet& charts, const Tiles& tiles, const std::vector<std::uint8_t>& mapOf) {
    const std::vector<const TriangleMesh*> meshes = {&mesh};
    const CutMesh cut = cutMeshes(meshes, {charts, tiles, glm::ivec2(kMapSide), mapOf}, 1)[0];
    std::vector<float> positions, uvs;
    for (const formats::CutVertex& vertex : cut.vertices) {
        const glm::vec3 position(valueAt(*mesh.find("POSITION"), vertex)), uv(valueAt(*mesh.find("TEXCOORD_1"), vertex));
        positions.insert(positions.end(), {position.x, position.y, position.z});
        uvs.insert(uvs.end(), {uv.x, uv.y});
    }
    TriangleMesh part;
    part.attributes = {attributeOf("POSITION", 3, positions), attributeOf("TEXCOORD_1", 2, uvs)};
    part.indices = cut.indices;
    const ChartSet found = cutChartsOf(part);
    EXPECT_EQ(found.charts.size(), 1u);
    return found.charts.front();
}

TEST(MeshCut, OnlyTheTileBeforeALineReadsATexelBeyondIt) {
    const TriangleMesh mesh = texelRectangle({10.3f, 20.3f}, {60.7f, 40.7f});
    const ChartSet charts = cutChartsOf(mesh);
    const Tiles tiles(boxesOf(charts.charts), kTile);
    ASSERT_EQ(tiles.gridOf(0), glm::ivec2(3, 1));
    const Chart left = chartOf(mesh, charts, tiles, {1, 0, 0}), middle = chartOf(mesh, charts, tiles, {0, 1, 0}),
                right = chartOf(mesh, charts, tiles, {0, 0, 1});
    EXPECT_EQ(left.texels(), glm::ivec2(kTile + 2, 22));
    EXPECT_EQ(middle.first, glm::ivec2(10 + kTile, 20));
    EXPECT_EQ(middle.texels(), glm::ivec2(kTile + 2, 22));
    EXPECT_EQ(right.first, glm::ivec2(10 + 2 * kTile, 20));
    EXPECT_EQ(right.texels(), glm::ivec2(51 - 2 * kTile + 1, 22));
}

TEST(MeshCut, EdgesOnTexelCentresBesideALineAreNotCut) {
    const float centre = 10 + kTile;  // of the texel beside the first line
    const TriangleMesh left = texelRectangle({10.3f, 20.3f}, {centre, 40.7f}), right = texelRectangle({centre, 20.3f}, {60.7f, 40.7f});
    const std::vector<const TriangleMesh*> meshes = {&left, &right};
    const auto charts = findCharts(meshes, std::vector<formats::Subject>(2, "rectangle"), kMapSide, kMapSide);
    ASSERT_TRUE(charts && charts->charts.size() == 1u);
    const Tiles tiles(boxesOf(charts->charts), kTile);
    ASSERT_EQ(tiles.gridOf(0), glm::ivec2(3, 1));
    const auto cut = cutMeshes(meshes, {*charts, tiles, glm::ivec2(kMapSide), {1, 0, 0}}, 1);
    EXPECT_EQ(cut[0].indices, left.indices);
    EXPECT_TRUE(cut[1].indices.empty());
}

/// Triangles without area in the map stay whole.
TEST(MeshCut, TrianglesWithoutAreaGoWithTheirFirstCorner) {
    TriangleMesh mesh;
    const float a = 10.0f / kMapSide, b = 90.0f / kMapSide;
    mesh.attributes = {attributeOf("POSITION", 3, {0, 0, 0, 1, 0, 0, 0, 1, 0}), attributeOf("TEXCOORD_1", 2, {a, a, b, b, b, b})};
    mesh.indices = {0, 1, 2};
    const std::vector<const TriangleMesh*> meshes = {&mesh};
    const std::vector<formats::Subject> names = {"line"};
    const auto charts = findCharts(meshes, names, kMapSide, kMapSide);
    ASSERT_TRUE(charts);
    const Tiles tiles(boxesOf(charts->charts), kTile);
    ASSERT_GT(tiles.count(), 4);
    std::vector<std::uint8_t> isFirst(static_cast<std::size_t>(tiles.count()), 0);
    isFirst.front() = 1;
    EXPECT_EQ(cutMeshes(meshes, {*charts, tiles, glm::ivec2(kMapSide), isFirst}, 1)[0].indices.size(), 3u);
    EXPECT_EQ(cutMeshes(meshes, {*charts, tiles, glm::ivec2(kMapSide), isFirst}, 0)[0].indices.size(), 0u);
}

}  // namespace
}  // namespace lightcook::atlas
