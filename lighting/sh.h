// Real spherical harmonics of order 2: evaluate, project, rotate, convolve, and the two sign conventions of files.
//
// Canonical inside the program: orthonormal, no Condon-Shortley phase, coefficient (l, m) at l * (l + 1) + m:
//   Y0 = 1/2 sqrt(1/pi)
//   Y1 = sqrt(3/4pi) y         Y2 = sqrt(3/4pi) z          Y3 = sqrt(3/4pi) x
//   Y4 = 1/2 sqrt(15/pi) xy    Y5 = 1/2 sqrt(15/pi) yz     Y6 = 1/4 sqrt(5/pi) (3z^2 - 1)
//   Y7 = 1/2 sqrt(15/pi) xz    Y8 = 1/4 sqrt(15/pi) (x^2 - y^2)
#pragma once

#include <array>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

namespace lighting {

inline constexpr int kShCount = 9;
inline constexpr std::array<int, kShCount> kShBand = {0, 1, 1, 1, 2, 2, 2, 2, 2};

/// Nine scalars, one a basis function: of a kernel, or of one channel of light.
using Sh = std::array<float, kShCount>;
/// Nine RGB coefficients: incident radiance, or whatever the name says.
using ShRgb = std::array<glm::vec3, kShCount>;
/// The same in double precision, for references and fits.
using ShDouble = std::array<double, kShCount>;
/// One factor a band l = 0, 1, 2: a zonal kernel's effect on each band.
using ShBands = std::array<double, 3>;

/// The nine basis functions at a unit direction.
Sh evaluateBasis(const glm::vec3& direction);
ShDouble evaluateBasis(const glm::dvec3& direction);

/// sum_i coefficients_i Y_i(direction).
float evaluate(const Sh& coefficients, const glm::vec3& direction);
double evaluate(const ShDouble& coefficients, const glm::dvec3& direction);
glm::vec3 evaluate(const ShRgb& coefficients, const glm::vec3& direction);

/// Coefficients of a directional light (delta) of the given intensity: intensity * Y_i(direction).
ShRgb projectDirectional(const glm::vec3& direction, const glm::vec3& intensity);

/// Scales each band: the convolution with a zonal kernel of those factors.
Sh convolve(const Sh& coefficients, const ShBands& bands);
ShRgb convolve(const ShRgb& coefficients, const ShBands& bands);

/// The linear map of coefficients that a rotation of the sphere is: band 1 by the 3 x 3 matrix itself, band 2 by its symmetric square.
/// coefficients(rotated f) = apply(coefficients(f)), where (rotated f)(w) = f(inverse(destinationFromSource) w).
class ShRotation {
public:
    explicit ShRotation(const glm::dmat3& destinationFromSource);
    Sh apply(const Sh& source) const;
    ShDouble apply(const ShDouble& source) const;
    ShRgb apply(const ShRgb& source) const;

private:
    std::array<std::array<double, 3>, 3> band1_;
    std::array<std::array<double, 5>, 5> band2_;
};

/// Negates indices 1, 3, 5, 7: from or to Condon-Shortley signs (it is its own inverse).
ShRgb flipCondonShortley(const ShRgb& coefficients);

/// Luminance-weighted coefficients. weights: of the working colour space.
Sh luminance(const ShRgb& coefficients, const glm::vec3& weights);
inline constexpr glm::vec3 kRec709Luminance{0.2126f, 0.7152f, 0.0722f};

}  // namespace lighting
