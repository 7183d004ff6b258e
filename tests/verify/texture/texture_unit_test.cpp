#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "lighting/cube.h"
#include "verify/texture_unit.h"

namespace lightcook::verify {
namespace {

formats::Image<glm::vec4> ramp(int width, int height) {
    formats::Image<glm::vec4> image(width, height);
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) image.at(x, y) = {x, y, x * y, 1};
    return image;
}

TEST(SampleBilinear, IsExactAtCentresAndLinearBetween) {
    const formats::Image<glm::vec4> image = ramp(5, 3);
    for (double y = 0; y <= 2; y += 0.25)
        for (double x = 0; x <= 4; x += 0.25) {
            const glm::vec4 value = sampleBilinear(image.view(), {(x + 0.5) / 5, (y + 0.5) / 3});
            EXPECT_NEAR(value.r, x, 1e-6);
            EXPECT_NEAR(value.g, y, 1e-6);
            EXPECT_NEAR(value.b, x * y, 1e-5);  // bilinear in x and y, so reproduced
        }
}

TEST(SampleBilinear, ClampsOrRepeatsAtTheEdges) {
    const formats::Image<glm::vec4> image = ramp(4, 2);
    EXPECT_EQ(sampleBilinear(image.view(), {0, 0}).r, 0);
    EXPECT_EQ(sampleBilinear(image.view(), {1, 1}).r, 3);
    EXPECT_NEAR(sampleBilinear(image.view(), {0, 0.25}, Wrap::Repeat, Wrap::Clamp).r, 1.5, 1e-6);  // halfway between 3 and 0
    EXPECT_NEAR(sampleBilinear(image.view(), {1, 0.25}, Wrap::Repeat, Wrap::Clamp).r, 1.5, 1e-6);
    EXPECT_NEAR(sampleBilinear(image.view(), {0.125, 0}, Wrap::Clamp, Wrap::Repeat).g, 0.5, 1e-6);
}

std::vector<formats::Image<glm::vec4>> cubeOf(int size, const auto& function) {
    std::vector<formats::Image<glm::vec4>> faces;
    for (int face = 0; face < 6; ++face) {
        formats::Image<glm::vec4> image(size, size);
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) image.at(x, y) = function(face, x, y, lighting::cubeTexelDirection(face, x, y, size));
        faces.push_back(std::move(image));
    }
    return faces;
}

TEST(SampleCube, TexelCentresGiveTheirTexels) {
    for (const int size : {1, 2, 5, 16}) {
        const auto cube = cubeOf(size, [](int face, int x, int y, const glm::dvec3&) { return glm::vec4(face, x, y, 1); });
        for (int face = 0; face < 6; ++face)
            for (int y = 0; y < size; ++y)
                for (int x = 0; x < size; ++x) {
                    const glm::vec4 value = sampleCube(cube, 3.0 * lighting::cubeTexelDirection(face, x, y, size));
                    EXPECT_LT(glm::length(value - glm::vec4(face, x, y, 1)), 1e-5) << size << " " << face << " " << x << " " << y;
                }
    }
}

/// A sampler that clamps at the faces' edges, or takes the wrong neighbour, is discontinuous there.
TEST(SampleCube, IsContinuousAcrossEdgesAndCorners) {
    std::mt19937 random(1);
    const int size = 4;
    const auto cube =
        cubeOf(size, [&](int, int, int, const glm::dvec3&) { return glm::vec4(static_cast<float>(random() % 1000) / 999.0f); });
    std::uniform_real_distribution<double> along(-1, 1);
    for (int i = 0; i < 20000; ++i) {
        glm::dvec3 edge(along(random), 1, 1);
        if (i % 10 == 0) edge.x = i % 20 == 0 ? 1 : -1;  // a corner
        for (int axis = 0; axis < 3; ++axis)
            if (random() % 2 == 0) edge[axis] = -edge[axis];
        const int turn = static_cast<int>(random() % 3);
        edge = glm::dvec3(edge[turn], edge[(turn + 1) % 3], edge[(turn + 2) % 3]);
        const glm::dvec3 step = 1e-7 * glm::dvec3(along(random), along(random), along(random));
        EXPECT_NEAR(sampleCube(cube, edge + step).r, sampleCube(cube, edge - step).r, 1e-5) << edge.x << " " << edge.y << " " << edge.z;
    }
}

/// A linear function of direction over the largest component is bilinear within a face; near the edges only the neighbour's distortion
/// remains.
TEST(SampleCube, SmoothFunctionsComeOutSmoothEverywhere) {
    const auto function = [](int, int, int, const glm::dvec3& d) { return glm::vec4(d.x + 2 * d.y - d.z); };
    const auto cube = cubeOf(64, function);
    std::mt19937 random(2);
    std::normal_distribution<double> normal;
    double worst = 0;
    for (int i = 0; i < 50000; ++i) {
        const glm::dvec3 d = glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
        worst = std::max(worst, std::abs(static_cast<double>(sampleCube(cube, d).r) - (d.x + 2 * d.y - d.z)));
    }
    // The curvature of a component over half a texel (1/64) is below 1e-3; an edge adds a shift of at most a quarter of a texel.
    EXPECT_LT(worst, 0.012);
}

}  // namespace
}  // namespace lightcook::verify
