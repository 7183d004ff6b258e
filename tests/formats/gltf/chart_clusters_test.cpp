#include "formats/chart_clusters.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <glm/vec2.hpp>
#include <random>
#include <set>
#include <tuple>

namespace lightcook::formats {
namespace {

using testing::HasSubstr;

/// Vertices at light-map UVs; positions are the same, flat.
TriangleMesh meshOf(const std::vector<float>& uvs, std::vector<std::uint32_t> indices) {
    TriangleMesh mesh;
    MeshAttribute& uv = mesh.attributes.emplace_back();
    uv.semantic = "TEXCOORD_1";
    uv.componentCount = 2;
    uv.values.resize(uvs.size() * sizeof(float));
    std::memcpy(uv.values.data(), uvs.data(), uv.values.size());
    mesh.indices = std::move(indices);
    return mesh;
}

/// 16 x 8 texels: the left half has cluster 3, the right half 7.
ClusterMap twoHalves() {
    return *ClusterMap::fromRuns(16, 8, std::vector<float>{3, 2, 7, 2, 3, 2, 7, 2});
}

TEST(ClusterMap, RunsAreBlocksRowByRow) {
    const ClusterMap map = twoHalves();
    for (int y = 0; y < 8; ++y)
        for (int x = 0; x < 16; ++x) EXPECT_EQ(map.at(x, y), x < 8 ? 3 : 7) << x << " " << y;
    EXPECT_EQ(map.at(-5, 100), 3);
    EXPECT_EQ(map.at(99, -1), 7);
}

TEST(ClusterMap, RunsThatDoNotFillTheMapAreRefused) {
    for (const std::vector<float>& runs :
         {std::vector<float>{}, {3, 7}, {3, 9}, {3, 1e9f}, {256, 8}, {-1, 8}, {0.5f, 8}, {NAN, 8}, {1, NAN}})
        EXPECT_FALSE(ClusterMap::fromRuns(16, 8, runs));
    EXPECT_FALSE(ClusterMap::fromRuns(0, 0, std::vector<float>{}));
}

TEST(ClustersOfVertices, AnIslandTakesTheClusterOfItsTexels) {
    // A quad in either half, and a vertex of no triangle.
    const auto found =
        clustersOfVertices(meshOf({0.05f, 0.1f, 0.45f, 0.1f, 0.45f, 0.9f, 0.05f, 0.9f, 0.55f, 0.1f, 0.95f, 0.1f, 0.95f, 0.9f, 0, 0},
                                  {0, 1, 2, 0, 2, 3, 4, 5, 6}),
                           twoHalves());
    ASSERT_TRUE(found) << found.error();
    EXPECT_THAT(*found, testing::ElementsAre(3, 3, 3, 3, 7, 7, 7, 0));
}

TEST(ClustersOfVertices, TrianglesBetweenTexelCentresFollowTheirIslandOrTheirCentroid) {
    // The first is a sliver at the right half's edge whose island lies in the left half; the second an island of its own.
    const auto found =
        clustersOfVertices(meshOf({0.05f, 0.1f, 0.45f, 0.1f, 0.45f, 0.9f, 0.51f, 0.5f, 0.60f, 0.50f, 0.605f, 0.50f, 0.60f, 0.505f},
                                  {1, 3, 2, 0, 1, 2, 4, 5, 6}),
                           twoHalves());
    ASSERT_TRUE(found) << found.error();
    EXPECT_THAT(*found, testing::ElementsAre(3, 3, 3, 3, 7, 7, 7));
}

TEST(ClustersOfVertices, AnIslandAcrossClustersIsRefusedByTexelAndTriangle) {
    const auto found = clustersOfVertices(meshOf({0.05f, 0.1f, 0.95f, 0.1f, 0.95f, 0.9f}, {0, 1, 2}), twoHalves());
    ASSERT_FALSE(found);
    EXPECT_THAT(found.error(), HasSubstr("found cluster 7 at texel (8,"));
    EXPECT_FALSE(clustersOfVertices(TriangleMesh{}, twoHalves()));
}

/// Includes places outside the map that do not fit an int.
TEST(ClustersOfVertices, UvsFarOutsideTheMapAreHarmless) {
    const auto found = clustersOfVertices(meshOf({1e30f, 1e30f, 2e30f, 1e30f, 1e30f, 2e30f}, {0, 1, 2}), twoHalves());
    ASSERT_TRUE(found) << found.error();
    EXPECT_THAT(*found, testing::Each(7));
}

using Polygon = std::vector<glm::dvec2>;

/// The part of a polygon on one side of a line across an axis.
Polygon clipped(const Polygon& polygon, int axis, double bound, bool keepsBelow) {
    Polygon kept;
    const auto depth = [&](const glm::dvec2& point) { return keepsBelow ? bound - point[axis] : point[axis] - bound; };
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const glm::dvec2 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
        if (depth(a) >= 0) kept.push_back(a);
        if ((depth(a) < 0) != (depth(b) < 0)) kept.push_back(a + (b - a) * (depth(a) / (depth(a) - depth(b))));
    }
    return kept;
}

/// Returns true if a part of the triangle lies inside the square of this half side around a texel's centre (clips the triangle).
bool meets(const Polygon& triangle, int x, int y, double half) {
    Polygon left = triangle;
    for (const bool keepsBelow : {false, true}) {
        left = clipped(left, 0, x + 0.5 + (keepsBelow ? half : -half), keepsBelow);
        left = clipped(left, 1, y + 0.5 + (keepsBelow ? half : -half), keepsBelow);
    }
    return !left.empty();
}

/// Twice the smallest area between a point and an edge, negative outside [texels^2].
double depthInside(const Polygon& triangle, const glm::dvec2& point) {
    const auto turn = [](const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c) {
        return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
    };
    const double sign = turn(triangle[0], triangle[1], triangle[2]) < 0 ? -1 : 1;
    double least = HUGE_VAL;
    for (std::size_t i = 0; i < 3; ++i) least = std::min(least, sign * turn(triangle[i], triangle[(i + 1) % 3], point));
    return least;
}

TEST(IslandRuns, AreTheTexelsThatClippingFinds) {
    constexpr int kWidth = 24, kHeight = 20;
    std::mt19937 random(11);
    std::uniform_real_distribution<float> anywhere(-0.2f, 1.2f), nearby(-0.1f, 0.1f);
    int withoutCentre = 0;
    for (int round = 0; round < 300; ++round) {
        const std::array<float, 2> start = {anywhere(random), anywhere(random)};
        std::vector<float> uvs;
        Polygon triangle;
        for (int corner = 0; corner < 3; ++corner) {
            for (std::size_t axis = 0; axis < 2; ++axis)
                uvs.push_back(round % 3 == 0 ? anywhere(random) : start[axis] + (round % 3 == 1 || axis == 0 ? nearby(random) : 0));
            triangle.push_back({static_cast<double>(uvs[uvs.size() - 2]) * kWidth, static_cast<double>(uvs.back()) * kHeight});
        }
        const TriangleMesh mesh = meshOf(uvs, {0, 1, 2});
        const TriangleMesh* list[] = {&mesh};
        std::set<std::pair<int, int>> inside, filtered;
        for (const IslandRun& run : islandRuns(list, kWidth, kHeight)) {
            EXPECT_EQ(run.island, 0);
            for (int x = run.begin; x < run.end; ++x) (run.isInside ? inside : filtered).insert({x, run.row});
        }
        bool hasCentre = false;
        for (int y = 0; y < kHeight; ++y)
            for (int x = 0; x < kWidth; ++x) hasCentre = hasCentre || depthInside(triangle, {x + 0.5, y + 0.5}) > 1e-9;
        for (int y = 0; y < kHeight; ++y)
            for (int x = 0; x < kWidth; ++x) {
                const double depth = depthInside(triangle, {x + 0.5, y + 0.5});
                EXPECT_TRUE(depth <= 1e-9 || inside.contains({x, y})) << round << " " << x << " " << y;
                EXPECT_TRUE(!hasCentre || depth >= -1e-9 || !inside.contains({x, y})) << round << " " << x << " " << y;
                EXPECT_TRUE(meets(triangle, x, y, 1) || !filtered.contains({x, y})) << round << " " << x << " " << y;
                EXPECT_TRUE(!meets(triangle, x, y, 0.998) || filtered.contains({x, y})) << round << " " << x << " " << y;
            }
        withoutCentre += hasCentre ? 0 : 1;
        EXPECT_TRUE(hasCentre || inside.size() == 1) << "one texel stands for an island without centres";
    }
    EXPECT_GT(withoutCentre, 50);
    EXPECT_LT(withoutCentre, 250);
}

TEST(IslandRuns, TrianglesThatShareVerticesAreOneIslandWhateverMeshTheyAreOf) {
    const TriangleMesh two = meshOf({0.1f, 0.1f, 0.3f, 0.1f, 0.3f, 0.9f, 0.1f, 0.9f, 0.7f, 0.1f, 0.9f, 0.1f, 0.9f, 0.9f},
                                    {0, 1, 2, 0, 2, 3, 4, 5, 6}),
                       one = meshOf({0.5f, 0.5f, 0.6f, 0.5f, 0.6f, 0.6f}, {0, 1, 2}), none;
    const TriangleMesh* list[] = {&two, &none, &one};
    std::set<int> islands;
    for (const IslandRun& run : islandRuns(list, 16, 16)) {
        islands.insert(run.island);
        EXPECT_EQ(run.island, run.begin < 7 ? 0 : run.begin < 10 ? 2 : 1) << run.begin;
    }
    EXPECT_EQ(islands, (std::set<int>{0, 1, 2}));
}

}  // namespace
}  // namespace lightcook::formats
