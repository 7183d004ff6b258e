// SH of an environment by exact projection, and the prefilter kernels with their zonal factors. docs/theory/lighting.md,
// "Pre-divided cubemaps".
#pragma once

#include "formats/environment.h"
#include "lighting/sh.h"

namespace lightcook::fit {

/// Returns lambda_i = integral of L Y_i over the sphere, for L constant over each texel. Panoramas: closed-form integral of each Y_i over
/// each texel; cube strips: Gauss quadrature (1e-9 relative). Sums in double, in one order.
lighting::ShRgb projectEnvironment(const formats::Environment& environment);

/// Rotationally symmetric kernels k(c; m) around the reflection vector r, c = r.l, for n = v = r, so that NoH^2 = (1 + c) / 2. Zero for
/// c <= 0. Divided by its integral over the sphere, so that constants stay constant.
enum class PrefilterKernel {
    Beckmann,  ///< D(NoH) c with D = exp(-tan^2(a)/m^2) / cos^4(a)
    Ggx,       ///< D(NoH) c with D = 1 / (1 + NoH^2 (m^2 - 1))^2, alpha = m
    Phong      ///< c^s with s = (1 / m^2 + 1) / 2, as wide as Beckmann at small m; m = 1 is Lambert
};

/// Returns k scaled to 1 at c = 1. c in [-1, 1], m in (0, 1].
double prefilterKernelShape(PrefilterKernel kernel, double m, double c);
/// Returns the same as a function of 1 - c, which keeps the digits that c loses in a narrow lobe.
double prefilterKernelShapeAt(PrefilterKernel kernel, double m, double versine);
/// Returns the exponent s of PrefilterKernel::Phong.
double phongExponent(double m);
/// Returns the integral of the shape over the sphere [sr]. m at least 1e-12.
double prefilterKernelIntegral(PrefilterKernel kernel, double m);
/// Returns the zonal factors of the normalised kernel, integral k(c) P_l(c) dw for l = 0, 1, 2. m in [0, 1]; below 1e-12 they are {1, 1,
/// 1}. Relative error below 1e-9.
lighting::ShBands prefilterKernelBands(PrefilterKernel kernel, double m);

}  // namespace lightcook::fit
