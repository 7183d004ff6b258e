// Edges that two charts share, found among triangles.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <random>

#include "verify/seams.h"

namespace lightcook::verify {
namespace {

constexpr glm::dvec2 kMapSize(64, 32);
const glm::vec3 kUp(0, 0, 1);

/// Returns a triangle of the plane z = 0; its UVs are the positions times `scale` plus `offset`.
SurfaceTriangle flat(const std::array<glm::dvec2, 3>& corners, const glm::dvec2& offset, double scale = 0.1) {
    SurfaceTriangle triangle{};
    for (std::size_t i = 0; i < 3; ++i) {
        triangle.position[i] = glm::dvec3(corners[i], 0);
        triangle.normal[i] = kUp;
        triangle.uv[i] = offset + scale * corners[i];
    }
    return triangle;
}

const std::array<glm::dvec2, 3> kLeft = {{{0, 0}, {1, 0}, {1, 1}}};   ///< has the edge (1, 0) to (1, 1)
const std::array<glm::dvec2, 3> kRight = {{{1, 0}, {2, 0}, {1, 1}}};  ///< has it too, the other way round

SplitEdges edgesOf(std::span<const SurfaceTriangle> triangles) {
    SeamFinder finder(kMapSize);
    for (const SurfaceTriangle& triangle : triangles) finder.add(triangle);
    return std::move(finder).finish();
}

TEST(SeamFinder, EdgesWithTwoPlacesInTheMapAreSplit) {
    const std::array triangles = {flat(kLeft, {0, 0}), flat(kRight, {0.5, 0.25})};
    const SplitEdges found = edgesOf(triangles);
    ASSERT_EQ(found.edges.size(), 1u);
    EXPECT_EQ(found.joined, 0);
    EXPECT_EQ(found.hard, 0);
    EXPECT_EQ(found.open, 4);
    const SplitEdge& edge = found.edges.front();
    EXPECT_EQ(edge.position[0], glm::dvec3(1, 0, 0));
    EXPECT_EQ(edge.position[1], glm::dvec3(1, 1, 0));
    for (std::size_t end = 0; end < 2; ++end) {
        EXPECT_NEAR(edge.uv[0][end].x, 0.1, 1e-12);
        EXPECT_NEAR(edge.uv[1][end].x, 0.6, 1e-12);
        EXPECT_NEAR(edge.uv[0][end].y, 0.1 * static_cast<double>(end), 1e-12);
        EXPECT_NEAR(edge.uv[1][end].y, 0.25 + 0.1 * static_cast<double>(end), 1e-12);
        EXPECT_EQ(edge.normal[end], kUp);
    }
    // 3.2 texels: at most one texel between neighbouring places, both ends among them.
    EXPECT_EQ(edge.placeCount(kMapSize), 5);
    const glm::dvec2 middle = edge.texelAt(1, 0.5, kMapSize);
    EXPECT_NEAR(middle.x, 0.6 * 64 - 0.5, 1e-12);
    EXPECT_NEAR(middle.y, 0.3 * 32 - 0.5, 1e-12);
}

TEST(SeamFinder, EdgesInsideAChartAreJoined) {
    const std::array triangles = {flat(kLeft, {0, 0}), flat(kRight, {0.001 / 64, 0})};
    const SplitEdges found = edgesOf(triangles);
    EXPECT_TRUE(found.edges.empty());
    EXPECT_EQ(found.joined, 1);
}

TEST(SeamFinder, RotatedAndMirroredChartsKeepTheirEndsTogether) {
    SurfaceTriangle rotated = flat(kRight, {0.5, 0}), mirrored = rotated;
    for (std::size_t i = 0; i < 3; ++i) {
        const glm::dvec2 p = kRight[i];
        rotated.uv[i] = {0.5 + 0.1 * p.y, 0.5 - 0.1 * p.x};
        mirrored.uv[i] = {0.9 - 0.1 * p.x, 0.1 * p.y};
    }
    for (const SurfaceTriangle& right : {rotated, mirrored}) {
        const std::array triangles = {flat(kLeft, {0, 0}), right};
        const SplitEdges found = edgesOf(triangles);
        ASSERT_EQ(found.edges.size(), 1u);
        // Corners 0 and 2 of the right triangle are the ends (1, 0) and (1, 1).
        EXPECT_EQ(found.edges.front().uv[1][0], right.uv[0]);
        EXPECT_EQ(found.edges.front().uv[1][1], right.uv[2]);
    }
    // A chart that is mirrored at the edge itself reads the same texels on both sides.
    SurfaceTriangle shared = flat(kRight, {0, 0});
    for (std::size_t i = 0; i < 3; ++i) shared.uv[i] = 0.1 * glm::dvec2(2 - kRight[i].x, kRight[i].y);
    const std::array triangles = {flat(kLeft, {0, 0}), shared};
    EXPECT_TRUE(edgesOf(triangles).edges.empty());
}

/// Returns the right triangle, folded up at the shared edge.
SurfaceTriangle folded(double degrees, const glm::vec3& normal) {
    SurfaceTriangle triangle = flat(kRight, {0.5, 0});
    const double angle = degrees * std::numbers::pi / 180;
    for (std::size_t i = 0; i < 3; ++i) {
        const double out = triangle.position[i].x - 1;
        triangle.position[i] = {1 + out * std::cos(angle), triangle.position[i].y, out * std::sin(angle)};
        triangle.normal[i] = normal;
    }
    return triangle;
}

TEST(SeamFinder, HardEdgesAreNoSeams) {
    // By normals of the vertices, and without any by those of the triangles.
    for (const bool hasNormals : {true, false})
        for (const double degrees : {0.0, 5.0, 9.5, 10.5, 90.0}) {
            SurfaceTriangle left = flat(kLeft, {0, 0});
            if (!hasNormals) left.normal = {};
            const double angle = degrees * std::numbers::pi / 180;
            const glm::vec3 turned(-std::sin(angle), 0, std::cos(angle));
            const std::array triangles = {left, folded(degrees, hasNormals ? turned : glm::vec3(0))};
            const SplitEdges found = edgesOf(triangles);
            EXPECT_EQ(found.edges.size(), degrees <= SeamFinder::kHardAngle ? 1u : 0u) << degrees << " " << hasNormals;
            EXPECT_EQ(found.hard, degrees <= SeamFinder::kHardAngle ? 0 : 1) << degrees << " " << hasNormals;
        }
    // Smooth shading around a corner is one surface.
    const std::array smooth = {flat(kLeft, {0, 0}), folded(90, kUp)};
    EXPECT_EQ(edgesOf(smooth).edges.size(), 1u);
    // A triangle that lies on the other one is a second surface.
    const std::array doubled = {flat(kLeft, {0, 0}), flat(kLeft, {0.5, 0})};
    EXPECT_TRUE(edgesOf(doubled).edges.empty());
}

TEST(SeamFinder, NearlyEqualPositionsAreMatched) {
    SurfaceTriangle right = flat(kRight, {0.5, 0});
    for (glm::dvec3& position : right.position) position += glm::dvec3(1e-6, -1e-6, 1e-6);
    const std::array triangles = {flat(kLeft, {0, 0}), right};
    EXPECT_EQ(edgesOf(triangles).edges.size(), 1u);
    for (glm::dvec3& position : right.position) position += glm::dvec3(1e-4, 0, 0);
    const std::array apart = {flat(kLeft, {0, 0}), right};
    EXPECT_TRUE(edgesOf(apart).edges.empty());
}

TEST(SeamFinder, TrianglesWithoutAreaHaveNoEdges) {
    SurfaceTriangle line = flat({{{1, 0}, {1, 1}, {1, 0.5}}}, {0.5, 0});
    const std::array triangles = {flat(kLeft, {0, 0}), line};
    const SplitEdges found = edgesOf(triangles);
    EXPECT_TRUE(found.edges.empty());
    EXPECT_EQ(found.open, 3);
}

/// A grid of quads, each a chart of its own or all one chart, with vertices that are a little off.
TEST(SeamFinder, EveryEdgeOfAGridIsFoundInAnyOrder) {
    constexpr int kSide = 40;
    std::mt19937 random(7);
    std::uniform_real_distribution<double> jitter(-2e-5, 2e-5);
    for (const bool isJittered : {false, true}) {
        std::vector<SurfaceTriangle> triangles;
        for (int y = 0; y < kSide; ++y)
            for (int x = 0; x < kSide; ++x) {
                const glm::dvec2 at(x, y), chart(0.001 * x, 0.002 * y);
                triangles.push_back(flat({{at, at + glm::dvec2(1, 0), at + glm::dvec2(1, 1)}}, chart, 0.02));
                triangles.push_back(flat({{at, at + glm::dvec2(1, 1), at + glm::dvec2(0, 1)}}, chart, 0.02));
            }
        if (isJittered)
            for (SurfaceTriangle& triangle : triangles)
                for (glm::dvec3& position : triangle.position) position += glm::dvec3(jitter(random), jitter(random), jitter(random));
        for (int order = 0; order < 2; ++order) {
            const SplitEdges found = edgesOf(triangles);
            EXPECT_EQ(found.edges.size(), 2u * kSide * (kSide - 1));
            EXPECT_EQ(found.joined, kSide * kSide);
            EXPECT_EQ(found.open, 4 * kSide);
            EXPECT_EQ(found.hard, 0);
            std::ranges::shuffle(triangles, random);
        }
    }
}

}  // namespace
}  // namespace lightcook::verify
