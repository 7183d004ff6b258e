#include "lighting/sphere.h"

#include <cassert>
#include <cmath>
#include <numbers>

namespace lightcook::lighting {

namespace {

using std::numbers::pi;

/// Azimuth between successive Fibonacci points, pi (3 - sqrt 5).
const double kGoldenAngle = pi * (3 - std::sqrt(5.0));

glm::dvec3 fromHeight(double z, double phi) {
    const double radius = std::sqrt(std::fmax(0.0, 1 - z * z));
    return {radius * std::cos(phi), radius * std::sin(phi), z};
}

}  // namespace

glm::dmat3 worldFromTangentFrame(const glm::dvec3& normal) {
    const double sign = std::copysign(1.0, normal.z);
    const double a = -1 / (sign + normal.z);
    const double b = normal.x * normal.y * a;
    return {glm::dvec3(1 + sign * normal.x * normal.x * a, sign * b, -sign * normal.x),
            glm::dvec3(b, sign + normal.y * normal.y * a, -normal.y), normal};
}

glm::dvec3 fibonacciHemisphere(int index, int count) {
    assert(0 <= index && index < count);
    return fromHeight((index + 0.5) / count, index * kGoldenAngle);
}

glm::dvec3 fibonacciSphere(int index, int count) {
    assert(0 <= index && index < count);
    return fromHeight(1 - (2.0 * index + 1) / count, index * kGoldenAngle);
}

glm::dvec2 equirectangularFromDirection(const glm::dvec3& direction) {
    // acos(y) by atan2, which keeps its digits near the poles.
    const double radius = std::sqrt(direction.x * direction.x + direction.z * direction.z);
    return {0.5 + std::atan2(direction.x, -direction.z) / (2 * pi), std::atan2(radius, direction.y) / pi};
}

glm::dvec3 directionFromEquirectangular(const glm::dvec2& uv) {
    const double azimuth = (uv.x - 0.5) * 2 * pi, theta = uv.y * pi;
    const double radius = std::sin(theta);
    return {radius * std::sin(azimuth), std::cos(theta), -radius * std::cos(azimuth)};
}

double equirectangularTexelSolidAngle(int y, int width, int height) {
    assert(0 <= y && y < height && width > 0);
    // cos(top) - cos(bottom) as a product, so that thin rows keep their digits.
    const double middle = pi * (y + 0.5) / height, half = pi * 0.5 / height;
    return 2 * pi / width * 2 * std::sin(middle) * std::sin(half);
}

}  // namespace lightcook::lighting
