// Real spherical harmonics of order 2: evaluate, project, rotate, convolve, and the two sign conventions of files.
//
// Canonical inside the program: orthonormal, no Condon-Shortley sign, coefficient (l, m) at l * (l + 1) + m
// (docs/theory/lighting.md, "Spherical harmonics"):
//   Y0 = 1/2 sqrt(1/pi)
//   Y1 = sqrt(3/4pi) y         Y2 = sqrt(3/4pi) z          Y3 = sqrt(3/4pi) x
//   Y4 = 1/2 sqrt(15/pi) xy    Y5 = 1/2 sqrt(15/pi) yz     Y6 = 1/4 sqrt(5/pi) (3z^2 - 1)
//   Y7 = 1/2 sqrt(15/pi) xz    Y8 = 1/4 sqrt(15/pi) (x^2 - y^2)
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

namespace lightcook::lighting {

inline constexpr int kShCount = 9;
inline constexpr std::array<int, kShCount> kShBand = {0, 1, 1, 1, 2, 2, 2, 2, 2};

/// Nine scalar coefficients: a kernel, or one channel of light.
using Sh = std::array<float, kShCount>;
/// Nine RGB coefficients: incident radiance, unless a name says otherwise.
using ShRgb = std::array<glm::vec3, kShCount>;
/// The same in double precision, for references and fits.
using ShDouble = std::array<double, kShCount>;
/// One factor for each band l = 0, 1, 2: the convolution with a zonal kernel.
using ShBands = std::array<double, 3>;

/// Constants of the basis, to 20 digits: 1/2 sqrt(1/pi), sqrt(3/4pi), 1/2 sqrt(15/pi), 1/4 sqrt(5/pi), 1/4 sqrt(15/pi).
inline constexpr double kShConstant = 0.28209479177387814347;
inline constexpr double kShLinear = 0.48860251190291992159;
inline constexpr double kShProduct = 1.0925484305920790705;
inline constexpr double kShZonal = 0.31539156525252000603;
inline constexpr double kShDifference = 0.54627421529603953527;

namespace detail {

template <class T, class Direction>
inline std::array<T, kShCount> basis(const Direction& d) {
    constexpr T constant = static_cast<T>(kShConstant), linear = static_cast<T>(kShLinear), product = static_cast<T>(kShProduct);
    constexpr T zonal = static_cast<T>(kShZonal), difference = static_cast<T>(kShDifference);
    return {constant,
            linear * d.y,
            linear * d.z,
            linear * d.x,
            product * d.x * d.y,
            product * d.y * d.z,
            zonal * (T(3) * d.z * d.z - T(1)),
            product * d.x * d.z,
            difference * (d.x * d.x - d.y * d.y)};
}

}  // namespace detail

/// Returns the nine basis functions at a unit direction. Inline, like evaluate and ShRotation::apply: they run for each texel and
/// direction.
inline Sh evaluateBasis(const glm::vec3& direction) {
    return detail::basis<float>(direction);
}
inline ShDouble evaluateBasis(const glm::dvec3& direction) {
    return detail::basis<double>(direction);
}

/// Returns sum_i coefficients_i Y_i(direction).
inline float evaluate(const Sh& coefficients, const glm::vec3& direction) {
    const Sh basis = evaluateBasis(direction);
    float sum = 0;
    for (std::size_t i = 0; i < kShCount; ++i) sum += coefficients[i] * basis[i];
    return sum;
}
inline double evaluate(const ShDouble& coefficients, const glm::dvec3& direction) {
    const ShDouble basis = evaluateBasis(direction);
    double sum = 0;
    for (std::size_t i = 0; i < kShCount; ++i) sum += coefficients[i] * basis[i];
    return sum;
}
inline glm::vec3 evaluate(const ShRgb& coefficients, const glm::vec3& direction) {
    const Sh basis = evaluateBasis(direction);
    glm::vec3 sum(0);
    for (std::size_t i = 0; i < kShCount; ++i) sum += coefficients[i] * basis[i];
    return sum;
}

/// Returns the coefficients of a directional light (delta), intensity * Y_i(direction).
ShRgb projectDirectional(const glm::vec3& direction, const glm::vec3& intensity);

/// Scales each band: the convolution with a zonal kernel of those factors.
Sh convolve(const Sh& coefficients, const ShBands& bands);
ShRgb convolve(const ShRgb& coefficients, const ShBands& bands);

/// A rotation of the sphere as a linear map of coefficients: band 1 by the 3 x 3 matrix, band 2 by its symmetric square.
/// coefficients(rotated f) = apply(coefficients(f)), where (rotated f)(w) = f(inverse(destinationFromSource) w).
class ShRotation {
public:
    explicit ShRotation(const glm::dmat3& destinationFromSource);
    Sh apply(const Sh& source) const { return applyWith(bandsFloat_, source, 0.0f); }
    ShDouble apply(const ShDouble& source) const { return applyWith(bandsDouble_, source, 0.0); }
    ShRgb apply(const ShRgb& source) const { return applyWith(bandsFloat_, source, glm::vec3(0)); }

private:
    template <class T>
    struct Bands {
        std::array<std::array<T, 3>, 3> linear{};     ///< rows and columns in the order of indices 1 2 3
        std::array<std::array<T, 5>, 5> quadratic{};  ///< 4 5 6 7 8
    };

    template <class T, class Coefficient>
    static std::array<Coefficient, kShCount> applyWith(const Bands<T>& bands, const std::array<Coefficient, kShCount>& source,
                                                       const Coefficient& zero) {
        std::array<Coefficient, kShCount> result{};
        result[0] = source[0];
        for (std::size_t row = 0; row < 3; ++row) {
            Coefficient sum = zero;
            for (std::size_t column = 0; column < 3; ++column) sum += bands.linear[row][column] * source[1 + column];
            result[1 + row] = sum;
        }
        for (std::size_t row = 0; row < 5; ++row) {
            Coefficient sum = zero;
            for (std::size_t column = 0; column < 5; ++column) sum += bands.quadratic[row][column] * source[4 + column];
            result[4 + row] = sum;
        }
        return result;
    }

    Bands<double> bandsDouble_;
    Bands<float> bandsFloat_;  ///< the same, rounded: for light maps, which are float
};

/// Returns the length of each band: the root of the sum of its squared coefficients.
inline ShBands bandLengths(const ShDouble& k) {
    return {std::abs(k[0]), std::sqrt(k[1] * k[1] + k[2] * k[2] + k[3] * k[3]),
            std::sqrt(k[4] * k[4] + k[5] * k[5] + k[6] * k[6] + k[7] * k[7] + k[8] * k[8])};
}
/// The same in doubles, where squares of floats neither underflow nor overflow.
inline ShBands bandLengths(const Sh& coefficients) {
    ShDouble k;
    std::ranges::copy(coefficients, k.begin());
    return bandLengths(k);
}

/// Negates coefficients 1, 3, 5, 7: from or to Condon-Shortley signs. It is its own inverse.
ShRgb flipCondonShortley(const ShRgb& coefficients);

/// Returns the luminance of each coefficient.
/// weights  luminance weights of the working colour space
Sh luminance(const ShRgb& coefficients, const glm::vec3& weights);
inline constexpr glm::vec3 kRec709Luminance{0.2126f, 0.7152f, 0.0722f};

}  // namespace lightcook::lighting
