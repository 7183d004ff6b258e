// The rasterizer of the rendered views.
#include "pipeline/assets/light_map/mesh_view.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/common.hpp>
#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>

#include "formats/gltf_scene.h"
#include "tests/formats/surface_fixture.h"
#include "tests/formats/temporary_folder.h"

namespace lightcook::pipeline {
namespace {

/// Appends a rectangle with corner `from` and sides `u` and `v`, whose UVs are those of the unit square scaled and shifted.
void addQuad(std::vector<verify::SurfaceTriangle>& triangles, const glm::dvec3& from, const glm::dvec3& u, const glm::dvec3& v,
             const glm::dvec2& uvFrom, const glm::dvec2& uvSize) {
    const auto position = [&](double a, double b) { return from + a * u + b * v; };
    const auto uv = [&](double a, double b) { return uvFrom + uvSize * glm::dvec2(a, b); };
    triangles.push_back({{position(0, 0), position(1, 0), position(1, 1)}, {}, {uv(0, 0), uv(1, 0), uv(1, 1)}});
    triangles.push_back({{position(0, 0), position(1, 1), position(0, 1)}, {}, {uv(0, 0), uv(1, 1), uv(0, 1)}});
}

/// A wall of 4 x 4 units at z = 0 that faces +z.
std::vector<verify::SurfaceTriangle> wall() {
    std::vector<verify::SurfaceTriangle> triangles;
    addQuad(triangles, {0, 0, 0}, {4, 0, 0}, {0, 4, 0}, {0, 0}, {0.5, 0.5});
    return triangles;
}

constexpr glm::dvec2 kSize(64, 64);

TEST(MeshView, FindsThePlaceOfATexel) {
    const auto triangles = wall();
    const auto place = placeAt(triangles, {0.125, 0.375}, kSize);
    ASSERT_TRUE(place);
    EXPECT_LT(glm::distance(place->position, glm::dvec3(1, 3, 0)), 1e-12);
    EXPECT_LT(glm::distance(place->normal, glm::dvec3(0, 0, 1)), 1e-12);
    EXPECT_NEAR(place->texelSide, 4.0 / 32, 1e-12) << "the wall is half of 64 texels";
    EXPECT_TRUE(placeAt(triangles, {0.51, 0.2}, kSize)) << "less than a texel beside the chart";
    EXPECT_FALSE(placeAt(triangles, {0.6, 0.2}, kSize));
    EXPECT_FALSE(placeAt({}, {0.1, 0.1}, kSize));
}

TEST(MeshView, AMirroredNodeKeepsItsFront) {
    const formats::TemporaryFolder folder;
    for (const float side : {1.0f, -1.0f}) {
        formats::writeSquare(folder / "square.glb", {.node = glm::scale(glm::mat4(1), glm::vec3(side, 1, 1))});
        const auto scene = formats::GltfScene::load(folder / "square.glb");
        ASSERT_TRUE(scene);
        const auto place = placeAt(litTriangles(*scene), {0.25, 0.75}, kSize);
        ASSERT_TRUE(place);
        EXPECT_LT(glm::distance(place->position, glm::dvec3(0.25 * side, 0, 0.75)), 1e-6);
        EXPECT_LT(glm::distance(place->normal, glm::dvec3(0, 1, 0)), 1e-12) << side;
    }
}

TEST(MeshView, TheCentreOfThePictureIsThePlace) {
    const auto triangles = wall();
    const glm::dvec2 uv(0.2, 0.3);
    const auto place = placeAt(triangles, uv, kSize);
    double distance = 0;
    const MeshCamera camera = cameraInFrontOf(triangles, *place, 1, distance);
    EXPECT_DOUBLE_EQ(distance, 2);
    const auto uvs = rasterized(triangles, camera, 64);
    const glm::dvec2 middle = 0.25 * (uvs.at(31, 31) + uvs.at(32, 31) + uvs.at(31, 32) + uvs.at(32, 32));
    EXPECT_LT(glm::distance(middle, uv), 1e-9);
    // Half of the picture is 1 unit: an eighth of the wall's UVs.
    EXPECT_NEAR(uvs.at(63, 32).x - uvs.at(0, 32).x, 0.25 * 63 / 64, 1e-9);
    EXPECT_GT(uvs.at(32, 0).y, uvs.at(32, 63).y) << "up in the scene is up in the picture";
}

TEST(MeshView, UvsAreThoseOfTheRay) {
    // A floor seen from above at a slant: the UVs of a pixel are those where its ray meets the floor.
    std::vector<verify::SurfaceTriangle> triangles;
    addQuad(triangles, {-50, 0, -50}, {0, 0, 100}, {100, 0, 0}, {0, 0}, {1, 1});
    MeshCamera camera;
    camera.eye = {1, 3, 2};
    camera.forward = glm::normalize(glm::dvec3(0.3, -1, -0.8));
    camera.right = glm::normalize(glm::cross(camera.forward, glm::dvec3(0, 1, 0)));
    camera.up = glm::cross(camera.right, camera.forward);
    camera.nearest = 1e-3;
    const int side = 33;
    const auto uvs = rasterized(triangles, camera, side);
    for (const auto& [x, y] : {std::pair(3, 5), std::pair(16, 16), std::pair(30, 29), std::pair(10, 1)}) {
        const glm::dvec3 ray =
            camera.forward + camera.slope * ((2 * (x + 0.5) / side - 1) * camera.right + (1 - 2 * (y + 0.5) / side) * camera.up);
        const glm::dvec3 hit = camera.eye - camera.eye.y / ray.y * ray;
        EXPECT_NEAR(uvs.at(x, y).x, (hit.z + 50) / 100, 1e-9);
        EXPECT_NEAR(uvs.at(x, y).y, (hit.x + 50) / 100, 1e-9);
    }
}

TEST(MeshView, NearerSurfacesHideOthersInAnyOrder) {
    std::vector<verify::SurfaceTriangle> triangles;
    addQuad(triangles, {1.5, 1.5, 1}, {1, 0, 0}, {0, 1, 0}, {0.6, 0.6}, {0.1, 0.1});
    for (const verify::SurfaceTriangle& triangle : wall()) triangles.push_back(triangle);
    MeshCamera camera;
    camera.eye = {2, 2, 4};
    camera.forward = {0, 0, -1};
    camera.right = {1, 0, 0};
    camera.up = {0, 1, 0};
    camera.nearest = 1e-3;
    const auto uvs = rasterized(triangles, camera, 31);
    std::reverse(triangles.begin(), triangles.end());
    const auto reversed = rasterized(triangles, camera, 31);
    EXPECT_GE(uvs.at(15, 15).x, 0.6) << "the small quad";
    EXPECT_LE(uvs.at(0, 15).x, 0.5) << "the wall";
    for (int y = 0; y < 31; ++y)
        for (int x = 0; x < 31; ++x) EXPECT_EQ(uvs.at(x, y), reversed.at(x, y));
}

TEST(MeshView, TheCameraStaysInFrontOfWhatIsInTheWay) {
    std::vector<verify::SurfaceTriangle> triangles = wall();
    const auto place = placeAt(triangles, {0.25, 0.26}, kSize);
    addQuad(triangles, {0, 0, 1}, {4, 0, 0}, {0, 4, 0}, {0.5, 0.5}, {0.5, 0.5});
    double distance = 0;
    const MeshCamera camera = cameraInFrontOf(triangles, *place, 1, distance);
    EXPECT_NEAR(distance, 0.95, 1e-9);
    EXPECT_LT(rasterized(triangles, camera, 16).at(8, 8).x, 0.5) << "the wall, not what stands before it";
}

TEST(MeshView, SurfacesBehindTheCameraAreClipped) {
    const auto triangles = wall();
    MeshCamera camera;
    camera.eye = {2, 2, 0.5};
    camera.forward = {1, 0, 0};
    camera.right = {0, 0, 1};
    camera.up = {0, 1, 0};
    camera.nearest = 1e-3;
    const auto uvs = rasterized(triangles, camera, 32);
    EXPECT_TRUE(std::isnan(uvs.at(31, 16).x)) << "to the right there is nothing";
    EXPECT_GT(uvs.at(0, 16).x, 0.25) << "to the left the wall ahead, none behind";
    camera.eye.z = -9;
    camera.forward = {0, 0, -1};
    EXPECT_TRUE(std::isnan(rasterized(triangles, camera, 8).at(4, 4).x));
}

}  // namespace
}  // namespace lightcook::pipeline
