// Bound of the local error for every normal, view and material, of a texel or of everything between four texels. Private to verify/.
//
// Shading is a linear functional of the light: a rotation and, for each band l, a factor (Response). For error e and reference r, both
// vectors of nine coefficients, t bounds the local error |e(n)| / (|r(n)| + floor) over all directions n if
//   s e(n) <= t (share r(n) + floor)   for both signs s and some share in [-1, 1],
// since |r| >= share r. Each condition asks whether a quadratic on the unit sphere, s e(n) - t share r(n), stays below a limit, and the
// maximum of such a quadratic is known exactly. The least such t is the maximum of a ratio, found by Dinkelbach's iteration (1967, On
// Nonlinear Fractional Programming): take the direction where the condition is violated most, set t to the ratio there, repeat.
//
// The condition is linear in (e, r). If it holds for several pairs it holds for every weighted mean of them, which is how the control
// vectors of a quad bound all positions in it (controls.h), and how a few responses bound all views and materials (shading.h).
#pragma once

#include <array>
#include <glm/vec3.hpp>
#include <limits>
#include <span>

#include "lighting/sh.h"

namespace lightcook::verify {

/// Error and reference of one channel: nine coefficients of incident radiance each.
struct ErrorPair {
    lighting::Sh error{}, reference{};
};

/// sum_l kExitNorm[l] |band l| bounds exit radiance over all normals: addition theorem, times the cosine's bands.
inline constexpr lighting::ShBands kExitNorm = {0.28209479177387814, 0.48860251190291992 * 2 / 3, 0.63078313050504001 / 4};
/// Returns sum_l factor_l length_l.
double bandSum(const lighting::ShBands& lengths, const lighting::ShBands& factors);

/// A zonal kernel in all rotations: light k is shaded to sum_l bands_l sum_m k_lm Y_lm(n) for any direction n, plus at most
/// sum_l residual_l |k_l|. Lambert's cosine is zonal about the normal, without residual. Glossy lobes are nearly zonal about their own
/// axis.
struct Response {
    lighting::ShBands bands{};
    lighting::ShBands residual{};
    /// Returns the largest response to a band of length 1.
    lighting::ShBands norms() const;
};
/// Exit radiance of a white Lambert surface under any normal.
inline constexpr Response kExitResponse{{1, 2.0 / 3, 1.0 / 4}, {}};

/// The pair and the direction at which a bound is reached, with the shaded error and reference there.
struct BoundPlace {
    std::size_t pair = 0;
    glm::dvec3 direction{0};
    double error = 0, reference = 0;
    lighting::ShBands bands{};  ///< of the response that reached the bound
};
/// Returns light shaded by a zonal kernel about a direction: sum_l bands_l sum_m k_lm Y_lm(n).
double shadedAbout(const lighting::Sh& light, const lighting::ShBands& bands, const glm::dvec3& n);

/// Returns an upper bound of |e| / (|r| + floor), where e and r are the responses to error and reference, over every direction, every
/// mean of the responses and 0, and every mean of the pairs (non-negative weights of sum 1, the same for error and reference). One pair is
/// a texel; the control vectors of a quad bound everything between four texels.
/// It is the least t with s e_j(n) <= t (share r_j(n) + floor) for every pair j, direction n, response and sign s, for the best of a few
/// shares from 1 to 0. Share 1 is exact for a texel whose reference is nowhere negative; smaller shares suit light that rings below zero.
/// floor   > 0
/// slack   band lengths of what may be added to any error: rounding, sampler tolerance
/// atMost  the result need not be tight above it
/// place   if not null, receives the place where the bound is reached; unchanged if the bound is 0 or not tight
double localErrorBound(std::span<const ErrorPair> pairs, std::span<const Response> responses, double floor, const lighting::ShBands& slack,
                       double atMost = std::numeric_limits<double>::infinity(), BoundPlace* place = nullptr);

/// Returns true if localErrorBound is proven not to exceed `limit`; faster. False proves nothing.
bool cannotExceed(std::span<const ErrorPair> pairs, std::span<const Response> responses, double floor, const lighting::ShBands& slack,
                  double limit);

}  // namespace lightcook::verify
