// SH of an environment by exact projection, and the zonal factors of the prefilter's kernels.
#pragma once

#include "formats/environment.h"
#include "lighting/sh.h"

namespace lightcook::fit {

/// lambda_i = integral of L Y_i over the sphere, of the piecewise-constant texels. Equirectangular: closed-form integral of each Y_i over
/// each texel; cube strips: Gauss quadrature per texel (1e-9 relative). Sums in double, in one order.
lighting::ShRgb projectEnvironment(const formats::Environment& environment);

/// Radially symmetric kernels k(c; m) around the reflection vector r, c = r.l, under the assumption n = v = r, so that the half vector h
/// has NoH^2 = (1 + c) / 2. Zero for c <= 0. Each is divided by its integral over the sphere: constants stay constant.
enum class PrefilterKernel {
    Beckmann,  ///< D(NoH) c with D = exp(-tan^2(a)/m^2) / cos^4(a)
    Ggx,       ///< D(NoH) c with D = 1 / (1 + NoH^2 (m^2 - 1))^2, alpha = m
    Phong      ///< c^s with s = (1 / m^2 + 1) / 2, as wide as Beckmann at small m; m = 1 is Lambert
};

/// k before its division by the integral; c in [-1, 1], m in (0, 1]. Scaled to 1 at c = 1.
double prefilterKernelShape(PrefilterKernel kernel, double m, double c);
/// The same as a function of 1 - c, which a narrow lobe needs: c itself has lost the digits.
double prefilterKernelShapeAt(PrefilterKernel kernel, double m, double versine);
/// s of PrefilterKernel::Phong.
double phongExponent(double m);
/// Integral of the shape over the sphere [sr].
double prefilterKernelIntegral(PrefilterKernel kernel, double m);
/// Zonal band factors of the normalised kernel, integral k(c) P_l(c) dw for l = 0, 1, 2; the first is 1. m = 0: {1, 1, 1}. Relative error
/// below 1e-9.
lighting::ShBands prefilterKernelBands(PrefilterKernel kernel, double m);

}  // namespace lightcook::fit
