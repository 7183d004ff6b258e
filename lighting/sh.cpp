#include "lighting/sh.h"

#include <glm/matrix.hpp>

namespace lighting {

namespace {

/// The quadratic forms whose values on the sphere are Y4 .. Y8 over kShDifference. Orthogonal, each of squared Frobenius norm 2.
std::array<glm::dmat3, 5> quadraticForms() {
    constexpr double a = 0.57735026918962576451;  // 1 / sqrt 3
    return {glm::dmat3(0, 1, 0, 1, 0, 0, 0, 0, 0), glm::dmat3(0, 0, 0, 0, 0, 1, 0, 1, 0), glm::dmat3(-a, 0, 0, 0, -a, 0, 0, 0, 2 * a),
            glm::dmat3(0, 0, 1, 0, 0, 0, 1, 0, 0), glm::dmat3(1, 0, 0, 0, -1, 0, 0, 0, 0)};
}

double frobenius(const glm::dmat3& a, const glm::dmat3& b) {
    double sum = 0;
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row) sum += a[column][row] * b[column][row];
    return sum;
}

}  // namespace

ShRotation::ShRotation(const glm::dmat3& destinationFromSource) {
    // A linear form a . w turns into (R a) . w; its vector lies in coefficients 3 1 2.
    constexpr std::array<int, 3> axisOf = {1, 2, 0};
    for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t column = 0; column < 3; ++column)
            bandsDouble_.linear[row][column] = destinationFromSource[axisOf[column]][axisOf[row]];
    // A quadratic form Q turns into R Q R'; its coefficients are its projections on the five forms.
    const std::array<glm::dmat3, 5> forms = quadraticForms();
    for (std::size_t column = 0; column < 5; ++column) {
        const glm::dmat3 rotated = destinationFromSource * forms[column] * glm::transpose(destinationFromSource);
        for (std::size_t row = 0; row < 5; ++row) bandsDouble_.quadratic[row][column] = 0.5 * frobenius(forms[row], rotated);
    }
    for (std::size_t row = 0; row < 3; ++row)
        for (std::size_t column = 0; column < 3; ++column)
            bandsFloat_.linear[row][column] = static_cast<float>(bandsDouble_.linear[row][column]);
    for (std::size_t row = 0; row < 5; ++row)
        for (std::size_t column = 0; column < 5; ++column)
            bandsFloat_.quadratic[row][column] = static_cast<float>(bandsDouble_.quadratic[row][column]);
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

}  // namespace lighting
