#include "fit/cubemap/kernel.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace lightcook::fit {
namespace {

constexpr double kSupportFraction = 1e-7;
constexpr double kNearHorizon = 0.02;    // [r.l] of KernelScale::horizonSlope
constexpr double kTailBegins = 6;        // [chord^2 over width^2]
constexpr double kWidestSquared = 0.36;  // rough lobes are as curved as their cosine, for any m

/// Returns 1 - r.l beyond which the shape is below the limit, by bisection: the shape falls monotonically.
double supportVersine(PrefilterKernel kernel, double m, double integral) {
    const double limit = kSupportFraction * integral / (4 * std::numbers::pi);
    double low = 0, high = 1;
    for (int iteration = 0; iteration < 60; ++iteration) {
        const double middle = 0.5 * (low + high);
        (prefilterKernelShapeAt(kernel, m, middle) > limit ? low : high) = middle;
    }
    return high;
}

}  // namespace

double KernelScale::widthSquaredAt(double chord) const {
    const double beyond = std::max(0.0, chord * chord - kTailBegins * widthSquared);
    return std::min(kWidestSquared, widthSquared + widthGrowth * chord * chord + tailGrowth * beyond);
}

KernelScale::Softened KernelScale::softened(float spread) const {
    double narrow = 1, wide = 1, sharpness = 0;  // squared widths of the kernel and of the softened one, in the same unit
    switch (kernel) {
        case PrefilterKernel::Beckmann:  // variance 2 m^2 for each axis
            narrow = m * m;
            wide = narrow + 0.5 * spread;
            sharpness = 1 / wide;
            break;
        case PrefilterKernel::Ggx:
            break;
        case PrefilterKernel::Phong:
            narrow = 1 / phongExponent(m);
            wide = narrow + spread;
            sharpness = 1 / wide;
            break;
    }
    return {static_cast<float>(sharpness), static_cast<float>(narrow / wide)};
}

KernelScale makeKernelScale(PrefilterKernel kernel, double m) {
    KernelScale scale;
    scale.kernel = kernel;
    scale.m = m;
    scale.mSquared = static_cast<float>(m * m);
    scale.oneMinusMSquared = static_cast<float>(1 - m * m);
    scale.integral = prefilterKernelIntegral(kernel, m);
    scale.horizonSlope = prefilterKernelShape(kernel, m, kNearHorizon) / kNearHorizon;
    const double support = supportVersine(kernel, m, scale.integral);
    scale.supportChord = std::sqrt(2 * support);
    scale.isNarrow = support < kNarrowVersine;
    switch (kernel) {
        case PrefilterKernel::Beckmann:
            scale.widthSquared = 2 * m * m;
            scale.widthGrowth = 0.1;
            scale.tailGrowth = 0.4;
            break;
        case PrefilterKernel::Ggx:
            scale.widthSquared = m * m;
            scale.widthGrowth = 0.125;
            break;
        case PrefilterKernel::Phong:
            scale.widthSquared = 1 / phongExponent(m);
            scale.widthGrowth = 0.1;
            scale.tailGrowth = 0.4;
            break;
    }
    scale.widthSquared = std::min(scale.widthSquared, kWidestSquared);
    return scale;
}

}  // namespace lightcook::fit
