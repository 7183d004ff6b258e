// The every-normal, every-position bound of a light map's local error. Private to verify/.
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

/// Sums of |band l| times these bound exit radiance over all normals: the addition theorem, times the cosine's bands.
inline constexpr lighting::ShBands kExitNorm = {0.28209479177387814, 0.48860251190291992 * 2 / 3, 0.63078313050504001 / 4};
/// Norms of the three bands.
lighting::ShBands bandNorms(const lighting::Sh& coefficients);
/// sum_l factor_l norm_l.
double bandSum(const lighting::ShBands& norms, const lighting::ShBands& factors);

/// A kind of shading, turned in every way: light k becomes sum_l bands_l sum_m k_lm Y_lm(n), with any n, and at most sum_l residual_l |k_l|
/// beside it. Lambert's cosine is round about the normal and has no residual; glossy lobes are nearly round about an axis of their own.
struct Response {
    lighting::ShBands bands{};
    lighting::ShBands residual{};
    /// What a band of length 1 gives at most.
    lighting::ShBands norms() const;
};
/// Exit radiance of a white Lambert surface under any normal.
inline constexpr Response kExitResponse{{1, 2.0 / 3, 1.0 / 4}, {}};

/// Where a bound is reached: which of the pairs, and the direction n; what error and reference are there, of the response that it is for.
struct BoundPlace {
    std::size_t pair = 0;
    glm::dvec3 direction{0};
    double error = 0, reference = 0;
};

/// A proven upper bound of |e| / (|r| + floor), e and r the responses to error and reference, over every direction n, every mean of the
/// responses and 0, and every mean (e, r) of the pairs: weights that are not negative and add up to 1, the same for error and reference.
/// One pair is a texel; the Bernstein control vectors of a quad, whose weights are the polynomials at a position, are all that lies between
/// four texels.
/// floor  > 0
/// slack  lengths of what may be added to each band of an error: rounding, and what a sampler is free to do
/// It is the least t with s e_j(n) <= t (share r_j(n) + floor) for every j, n, response and sign s, for the best of a few shares from 1 to
/// 0. Each condition is a quadratic on the sphere, whose maximum is known exactly; t is found by Dinkelbach's iteration (1967, On Nonlinear
/// Fractional Programming). Share 1 is exact for a texel whose reference is nowhere negative, less serves light that rings below zero.
/// atMost  not told more closely above it
/// place   if not null, where it is reached; left alone where the bound is no larger than 0, or not told
double localErrorBound(std::span<const ErrorPair> pairs, std::span<const Response> responses, double floor, const lighting::ShBands& slack,
                       double atMost = std::numeric_limits<double>::infinity(), BoundPlace* place = nullptr);

/// An axis, and how far the unit band 2 about any axis near it can be from the one about it.
struct AxisCone {
    glm::vec3 axis{0};     ///< unit
    double deviation = 0;  ///< at most sqrt 3
};
/// Of every mean of these vectors, turned to unit length. Two unit band 2 (sqrt(4 pi / 5) Y_2m) about axes an angle a apart differ by a
/// vector of squared length 2 - 2 P_2(cos a) = 3 sin^2 a, by the addition theorem. The axis of a mean stays in the narrowest cone around
/// the vectors' own mean that holds them all, which is convex below a right angle; where there is none, or a vector is 0, sqrt 3 holds for
/// every axis and for none. rounding  what may be missing from a vector's components
AxisCone axisCone(std::span<const glm::vec3> vectors, double rounding);

/// Quicker: whether that bound is proven not to exceed `limit`. False says nothing.
bool staysWithin(std::span<const ErrorPair> pairs, std::span<const Response> responses, double floor, const lighting::ShBands& slack,
                 double limit);

}  // namespace lightcook::verify
