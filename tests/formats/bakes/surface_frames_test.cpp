#include "formats/bakes/surface_frames.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <glm/ext/matrix_transform.hpp>
#include <glm/geometric.hpp>

#include "tests/formats/surface_fixture.h"

namespace lightcook::formats {
namespace {

using glm::vec3;

constexpr int kFramesSide = 8;

SurfaceFrame frameOf(const Square& square, int x = 3, int y = 5) {
    const TemporaryFolder folder;
    writeSquare(folder / "square.glb", square);
    const auto frames = SurfaceFrames::load(folder / "square.glb", kFramesSide, kFramesSide);
    if (!frames) {
        ADD_FAILURE() << frames.error().line();
        return {};
    }
    return frames->rows(y, 1).at(x, 0);
}

void expectFrame(const SurfaceFrame& frame, const vec3& tangent, const vec3& bitangent, const vec3& normal) {
    for (int axis = 0; axis < 3; ++axis) {
        EXPECT_NEAR(frame.tangent[axis], tangent[axis], 1e-6f) << "tangent, axis " << axis;
        EXPECT_NEAR(frame.bitangent[axis], bitangent[axis], 1e-6f) << "bitangent, axis " << axis;
        EXPECT_NEAR(frame.normal[axis], normal[axis], 1e-6f) << "normal, axis " << axis;
    }
}

/// A picture on the square has u along x and its top at z = 0: up is -z.
TEST(SurfaceFrames, TangentsFollowThePictureOfTexcoord0) {
    expectFrame(frameOf({}), {1, 0, 0}, {0, 0, -1}, {0, 1, 0});
    // Turned: u = z, v = -x, so that up in the picture is +x.
    expectFrame(frameOf({.texture = glm::mat2(0, -1, 1, 0)}), {0, 0, 1}, {1, 0, 0}, {0, 1, 0});
    // Mirrored: u = -x.
    expectFrame(frameOf({.texture = glm::mat2(-1, 0, 0, 1)}), {-1, 0, 0}, {0, 0, -1}, {0, 1, 0});
    // Sheared: u = x + z, v = z; v stays the same along x. The bitangent is made perpendicular.
    expectFrame(frameOf({.texture = glm::mat2(1, 0, 1, 1)}), {1, 0, 0}, {0, 0, -1}, {0, 1, 0});
}

TEST(SurfaceFrames, StoredTangentsComeFirstAndTexcoord1Last) {
    expectFrame(frameOf({.texture = glm::mat2(0, -1, 1, 0), .tangent = glm::vec4(0, 0, -1, -1)}), {0, 0, -1}, {1, 0, 0}, {0, 1, 0});
    expectFrame(frameOf({.texture = {}}), {1, 0, 0}, {0, 0, -1}, {0, 1, 0});
}

TEST(SurfaceFrames, NodesTurnAndMirrorThem) {
    // A quarter about z: x becomes y, y becomes -x.
    const glm::mat4 turned = glm::rotate(glm::mat4(1), glm::radians(90.0f), vec3(0, 0, 1));
    expectFrame(frameOf({.node = turned}), {0, 1, 0}, {0, 0, -1}, {-1, 0, 0});
    // Mirrored in x: the picture's right is -x, its top still -z, and the surface still faces +y.
    expectFrame(frameOf({.node = glm::scale(glm::mat4(1), vec3(-1, 1, 1))}), {-1, 0, 0}, {0, 0, -1}, {0, 1, 0});
    // Twice as long in x and tilted normals would be wrong with the matrix itself.
    const glm::mat4 slanted = turned * glm::scale(glm::mat4(1), vec3(2, 1, 1));
    expectFrame(frameOf({.node = slanted}), {0, 1, 0}, {0, 0, -1}, {-1, 0, 0});
}

TEST(SurfaceFrames, TexelsThatNoTriangleTouchesHaveNoSurface) {
    // UVs to 0.55 of 8 texels: 4.4. The fifth column is touched, the sixth is not.
    const Square part = {.lightMap = {0.55f, 1}};
    EXPECT_TRUE(frameOf(part, 4, 2).isSurface());
    EXPECT_FALSE(frameOf(part, 5, 2).isSurface());
    EXPECT_TRUE(frameOf(part, 0, 7).isSurface());
}

TEST(SurfaceFrames, CutsIntoStripsGiveTheSameFrames) {
    const TemporaryFolder folder;
    writeSquare(folder / "square.glb", {.lightMap = {0.8f, 0.7f}});
    const auto frames = SurfaceFrames::load(folder / "square.glb", kFramesSide, kFramesSide);
    ASSERT_TRUE(frames) << frames.error().line();
    const Image<SurfaceFrame> whole = frames->rows(0, kFramesSide);
    for (int y = 0; y < kFramesSide; ++y) {
        const Image<SurfaceFrame> row = frames->rows(y, 1);
        for (int x = 0; x < kFramesSide; ++x) {
            EXPECT_EQ(row.at(x, 0).normal, whole.at(x, y).normal);
            EXPECT_EQ(row.at(x, 0).tangent, whole.at(x, y).tangent);
        }
    }
}

}  // namespace
}  // namespace lightcook::formats
