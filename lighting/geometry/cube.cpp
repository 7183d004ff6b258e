#include "lighting/cube.h"

#include <array>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>

namespace lightcook::lighting {

namespace {

/// Direction = major + u * right + v * down, before normalisation.
struct FaceAxes {
    glm::dvec3 major, right, down;
};
const std::array<FaceAxes, 6> kFaces = {{
    {{1, 0, 0}, {0, 0, -1}, {0, -1, 0}},
    {{-1, 0, 0}, {0, 0, 1}, {0, -1, 0}},
    {{0, 1, 0}, {1, 0, 0}, {0, 0, 1}},
    {{0, -1, 0}, {1, 0, 0}, {0, 0, -1}},
    {{0, 0, 1}, {1, 0, 0}, {0, -1, 0}},
    {{0, 0, -1}, {-1, 0, 0}, {0, -1, 0}},
}};

/// Returns the major axis. Ties go to x, then y, then z, so that edges and corners belong to one face.
int majorFace(const glm::dvec3& direction) {
    const glm::dvec3 size(std::abs(direction.x), std::abs(direction.y), std::abs(direction.z));
    if (size.x >= size.y && size.x >= size.z) return direction.x >= 0 ? 0 : 1;
    if (size.y >= size.z) return direction.y >= 0 ? 2 : 3;
    return direction.z >= 0 ? 4 : 5;
}

}  // namespace

glm::dvec3 directionFromCube(CubeCoordinate coordinate) {
    assert(0 <= coordinate.face && coordinate.face < 6);
    const FaceAxes& axes = kFaces[static_cast<std::size_t>(coordinate.face)];
    return glm::normalize(axes.major + coordinate.uv.x * axes.right + coordinate.uv.y * axes.down);
}

CubeCoordinate cubeFromDirection(const glm::dvec3& direction) {
    const int face = majorFace(direction);
    const FaceAxes& axes = kFaces[static_cast<std::size_t>(face)];
    const double size = glm::dot(direction, axes.major);
    assert(size > 0);
    return {face, {glm::dot(direction, axes.right) / size, glm::dot(direction, axes.down) / size}};
}

glm::dvec3 cubeTexelDirection(int face, int x, int y, int size) {
    assert(0 <= x && x < size && 0 <= y && y < size);
    return directionFromCube({face, {(2.0 * x + 1) / size - 1, (2.0 * y + 1) / size - 1}});
}

double cubeCornerSolidAngle(double u, double v) {
    return std::atan2(u * v, std::sqrt(1 + u * u + v * v));
}

double cubeTexelSolidAngle(int x, int y, int size) {
    assert(0 <= x && x < size && 0 <= y && y < size);
    const double u0 = 2.0 * x / size - 1, u1 = 2.0 * (x + 1) / size - 1;
    const double v0 = 2.0 * y / size - 1, v1 = 2.0 * (y + 1) / size - 1;
    return cubeCornerSolidAngle(u1, v1) - cubeCornerSolidAngle(u0, v1) - cubeCornerSolidAngle(u1, v0) + cubeCornerSolidAngle(u0, v0);
}

}  // namespace lightcook::lighting
