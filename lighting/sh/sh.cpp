#include "lighting/sh.h"

namespace lightcook::lighting {

namespace {

using Band2 = std::array<double, 5>;

/// Returns u' E v for the five quadratic forms E whose values on the sphere are Y4 .. Y8 over kShDifference: half the band-2 coefficients
/// of the form u v' + v u'. The forms are orthogonal, each of squared Frobenius norm 2.
Band2 bilinear(const glm::dvec3& u, const glm::dvec3& v) {
    constexpr double a = 0.57735026918962576451;  // 1 / sqrt 3
    return {u.x * v.y + u.y * v.x, u.y * v.z + u.z * v.y, a * (2 * u.z * v.z - u.x * v.x - u.y * v.y), u.x * v.z + u.z * v.x,
            u.x * v.x - u.y * v.y};
}

}  // namespace

ShRotation::ShRotation(const glm::dmat3& destinationFromSource) {
    const glm::dmat3& rotation = destinationFromSource;
    // A linear form a . w becomes (R a) . w; the vector a is (coefficient 3, 1, 2).
    constexpr std::array<int, 3> axisOf = {1, 2, 0};
    for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t column = 0; column < 3; ++column) {
            bandsDouble_.linear[row][column] = rotation[axisOf[column]][axisOf[row]];
            bandsFloat_.linear[row][column] = static_cast<float>(bandsDouble_.linear[row][column]);
        }
    // A quadratic form Q becomes R Q R': xy becomes the product of the rotated axes x and y, and so on.
    const Band2 xx = bilinear(rotation[0], rotation[0]), yy = bilinear(rotation[1], rotation[1]), zz = bilinear(rotation[2], rotation[2]);
    const Band2 xy = bilinear(rotation[0], rotation[1]), yz = bilinear(rotation[1], rotation[2]), xz = bilinear(rotation[0], rotation[2]);
    constexpr double halfRoot = 0.28867513459481288225;  // 1 / (2 sqrt 3)
    for (std::size_t row = 0; row < 5; ++row) {
        bandsDouble_.quadratic[row] = {xy[row], yz[row], halfRoot * (2 * zz[row] - xx[row] - yy[row]), xz[row], 0.5 * (xx[row] - yy[row])};
        for (std::size_t column = 0; column < 5; ++column)
            bandsFloat_.quadratic[row][column] = static_cast<float>(bandsDouble_.quadratic[row][column]);
    }
}

ShRgb projectDirectional(const glm::vec3& direction, const glm::vec3& intensity) {
    const Sh basis = evaluateBasis(direction);
    ShRgb result{};
    for (std::size_t i = 0; i < kShCount; ++i) result[i] = intensity * basis[i];
    return result;
}

Sh convolve(const Sh& coefficients, const ShBands& bands) {
    Sh result{};
    for (std::size_t i = 0; i < kShCount; ++i)
        result[i] = static_cast<float>(bands[static_cast<std::size_t>(kShBand[i])]) * coefficients[i];
    return result;
}

ShRgb convolve(const ShRgb& coefficients, const ShBands& bands) {
    ShRgb result{};
    for (std::size_t i = 0; i < kShCount; ++i)
        result[i] = static_cast<float>(bands[static_cast<std::size_t>(kShBand[i])]) * coefficients[i];
    return result;
}

ShRgb flipCondonShortley(const ShRgb& coefficients) {
    ShRgb result = coefficients;
    for (std::size_t i = 1; i < kShCount; i += 2) result[i] = -result[i];
    return result;
}

Sh luminance(const ShRgb& coefficients, const glm::vec3& weights) {
    Sh result{};
    for (std::size_t i = 0; i < kShCount; ++i)
        result[i] = weights.x * coefficients[i].x + weights.y * coefficients[i].y + weights.z * coefficients[i].z;
    return result;
}

}  // namespace lightcook::lighting
