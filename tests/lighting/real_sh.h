// The SH basis in long double, as a truth beside lighting::evaluateBasis.
#pragma once

#include <array>
#include <cmath>

#include "lighting/sh.h"

namespace lightcook::test {

using Real = long double;
using RealSh = std::array<Real, lighting::kShCount>;

inline constexpr Real kRealPi = 3.14159265358979323846264338327950288L;

/// Returns the basis functions towards a unit direction (docs/theory/lighting.md).
inline RealSh realBasis(Real x, Real y, Real z) {
    const Real linear = std::sqrt(3 / (4 * kRealPi)), product = std::sqrt(15 / kRealPi) / 2, zonal = std::sqrt(5 / kRealPi) / 4;
    return {std::sqrt(1 / kRealPi) / 2,
            linear * y,
            linear * z,
            linear * x,
            product * x * y,
            product * y * z,
            zonal * (3 * z * z - 1),
            product * x * z,
            product / 2 * (x * x - y * y)};
}

}  // namespace lightcook::test
