// Intervals that contain the derivative of a specular kernel with respect to the view's angle. Part of the bound in lut_bound.cpp.
// Private to verify/.
//
// A kernel is an integral over half vectors of  w Y_i(light) (distribution of half vectors),  with the attenuation
// w = max(0, min(u, 2, 4 c u - 2)) of lighting/area_specular.h: a maximum of minima of lines in u. Over a box of views and half vectors
//   - u, c and the slopes of the lines that may be active are intervals of monotone functions at the box's ends;
//   - Y_i of the mirrored direction is its value at the box's centre, plus or minus (rotation) * l * |Y_l|: a function of band l turns no
//   faster;
//   - the product rule for intervals gives d/dtheta (w Y_i), and the same times Schlick's (1 - VoH)^5.
// Weighted by the share of half vectors in each box, which is a closed form of the distribution, the sum over all boxes contains the
// derivative of the kernel.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "lighting/sh.h"
#include "verify/error/interval.h"
#include "verify/lut.h"

namespace lightcook::verify::lut {

/// Returns what two intervals have in common: an empty one, whose low end is above the high one, where that is nothing.
inline Interval intersectionOf(const Interval& a, const Interval& b) {
    return {std::max(a.low, b.low), std::min(a.high, b.high)};
}

using EntryIntervals = std::array<Interval, 12>;
/// The coefficients of a kernel, and the entries of its C and D parts in SpecularKernelEntries.
inline constexpr std::array<std::size_t, 6> kKernelCoefficients = {0, 2, 3, 6, 7, 8};
inline constexpr std::array<std::size_t, 6> kEntryOfC = {0, 1, 2, 3, 8, 9}, kEntryOfD = {4, 5, 6, 7, 10, 11};

/// A box of views and half vectors, in radians.
struct HalfVectorBox {
    double theta0, theta1;  ///< polar angles of the view
    double psi0, psi1;      ///< polar angles of the half vector
    double phi0, phi1;      ///< azimuths of the half vector, from the view's side

    double viewRadius() const { return (theta1 - theta0) / 2; }
    double halfRadius() const { return (psi1 - psi0) / 2 + std::sin(psi1) * (phi1 - phi0) / 2; }
};

/// Adds intervals of d/dtheta (w Y_i) over a box to the C entries of `sums`, and of d/dtheta (w Y_i (1 - VoH)^5) to the D entries.
void addDerivative(const HalfVectorBox& box, EntryIntervals& sums);

/// Returns intervals of the derivative of a Phong kernel over views in [theta0, theta1]. Phong lobes rotate rigidly with the reflected
/// direction, so their derivative is that of Y_i(reflection) times a band factor.
/// bands  lighting::phongBands of the lobe
EntryIntervals phongDerivative(double theta0, double theta1, const lighting::ShBands& bands);

}  // namespace lightcook::verify::lut
