#include "lighting/cube.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "tests/lighting/quadrature.h"

namespace lightcook::lighting {
namespace {

using test::gaussLegendre;
using test::kPi;
using test::randomDirection;

TEST(Cube, FacesHaveTheOrientationOfOpenGl) {
    const double u = 0.3, v = -0.6;
    const glm::dvec3 expected[6] = {{1, -v, -u}, {-1, -v, u}, {u, 1, v}, {u, -1, -v}, {u, -v, 1}, {-u, -v, -1}};
    for (int face = 0; face < 6; ++face) {
        const glm::dvec3 direction = directionFromCube({face, {u, v}});
        for (int i = 0; i < 3; ++i) EXPECT_NEAR(direction[i], glm::normalize(expected[face])[i], 1e-15) << face;
    }
}

TEST(Cube, DirectionsRoundTripThroughTheirFace) {
    std::mt19937_64 random(41);
    int used[6] = {};
    for (int trial = 0; trial < 10000; ++trial) {
        const glm::dvec3 w = randomDirection(random);
        const CubeCoordinate at = cubeFromDirection(w);
        ++used[at.face];
        EXPECT_LE(std::abs(at.uv.x), 1);
        EXPECT_LE(std::abs(at.uv.y), 1);
        const glm::dvec3 back = directionFromCube(at);
        for (int i = 0; i < 3; ++i) EXPECT_NEAR(back[i], w[i], 1e-15);
        const CubeCoordinate longer = cubeFromDirection(4.0 * w);
        EXPECT_EQ(longer.face, at.face);
        EXPECT_EQ(longer.uv, at.uv);
    }
    for (const int count : used) EXPECT_NEAR(count, 10000 / 6.0, 200);
}

TEST(Cube, EdgesAndCornersStayInsideAFace) {
    for (const double x : {-1.0, 0.0, 1.0})
        for (const double y : {-1.0, 0.0, 1.0})
            for (const double z : {-1.0, 0.0, 1.0}) {
                if (x == 0 && y == 0 && z == 0) continue;
                const CubeCoordinate at = cubeFromDirection({x, y, z});
                EXPECT_LE(std::abs(at.uv.x), 1);
                EXPECT_LE(std::abs(at.uv.y), 1);
                EXPECT_NEAR(glm::dot(directionFromCube(at), glm::normalize(glm::dvec3(x, y, z))), 1, 1e-15);
            }
}

TEST(Cube, TexelCentresRoundTrip) {
    for (const int size : {1, 2, 5, 16})
        for (int face = 0; face < 6; ++face)
            for (int y = 0; y < size; ++y)
                for (int x = 0; x < size; ++x) {
                    const CubeCoordinate at = cubeFromDirection(cubeTexelDirection(face, x, y, size));
                    EXPECT_EQ(at.face, face);
                    EXPECT_NEAR((at.uv.x + 1) / 2 * size, x + 0.5, 1e-13);
                    EXPECT_NEAR((at.uv.y + 1) / 2 * size, y + 0.5, 1e-13);
                }
}

TEST(CubeSolidAngle, SixFacesAddUpToTheSphere) {
    for (const int size : {1, 2, 3, 16, 128, 333}) {
        double sum = 0;
        for (int y = 0; y < size; ++y)
            for (int x = 0; x < size; ++x) sum += cubeTexelSolidAngle(x, y, size);
        EXPECT_NEAR(6 * sum, 4 * kPi, 1e-10) << size;
    }
}

TEST(CubeSolidAngle, MatchesIntegrationOverTheTexel) {
    for (const int size : {2, 7, 64, 1024})
        for (const int y : {0, size / 3, size - 1})
            for (const int x : {0, size / 2, size - 1}) {
                const test::Rule us = gaussLegendre(24, 2.0 * x / size - 1, 2.0 * (x + 1) / size - 1);
                const test::Rule vs = gaussLegendre(24, 2.0 * y / size - 1, 2.0 * (y + 1) / size - 1);
                double sum = 0;
                for (std::size_t i = 0; i < us.nodes.size(); ++i)
                    for (std::size_t j = 0; j < vs.nodes.size(); ++j)
                        sum += us.weights[i] * vs.weights[j] * std::pow(1 + us.nodes[i] * us.nodes[i] + vs.nodes[j] * vs.nodes[j], -1.5);
                EXPECT_NEAR(cubeTexelSolidAngle(x, y, size), sum, 1e-15 + 1e-9 * sum) << size << ' ' << x << ' ' << y;
            }
}

}  // namespace
}  // namespace lightcook::lighting
