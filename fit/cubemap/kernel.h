// The prefilter kernels for eight texels at a time, and the extent and cell size that they need. Internal to fit/cubemap.
//
// Everything is a function of the squared chord q = |r - l|^2 = 2 (1 - r.l): the difference of nearby unit vectors keeps digits that r.l
// loses.
#pragma once

#include <bit>
#include <cstdint>

#include "fit/environment_sh.h"

namespace lightcook::fit {

/// Vector extensions of GCC and Clang: the same bits on every instruction set, one output texel a lane.
using Float8 = float __attribute__((vector_size(32)));
using Double8 = double __attribute__((vector_size(64)));
using Int8 = std::int32_t __attribute__((vector_size(32)));

/// Largest 1 - r.l of the support of a narrow kernel. Cells can be a little farther; the formulas of the shapes hold up to twice that.
inline constexpr double kNarrowVersine = 0.4;

/// Widths of a kernel, which decide how coarse the cells may be.
struct KernelScale {
    PrefilterKernel kernel = PrefilterKernel::Beckmann;
    double m = 0;
    double widthSquared = 0;     ///< [chord^2] of the lobe's core: one standard deviation
    double widthGrowth = 0;      ///< growth of width^2 per chord^2: the tail weighs little
    double tailGrowth = 0;       ///< additional growth beyond 2.4 widths, where a Gaussian has fallen to 1/20
    double integral = 0;         ///< [sr] of the shape over the sphere
    double horizonSlope = 0;     ///< slope of the shape over r.l just above r.l = 0: the size of its kink
    double supportChord = 0;     ///< beyond it the kernel is below 1e-7 of a constant kernel's value
    bool isNarrow = false;       ///< the support lies within kNarrowVersine: shapes need no guard at the horizon
    float mSquared = 0;          ///< m^2
    float oneMinusMSquared = 0;  ///< 1 - m^2

    /// Returns the squared width of the kernel at a chord from its centre [chord^2]: the limit for cells there.
    double widthSquaredAt(double chord) const;

    /// The kernel for a cell of some spread: its mean over the cell is, to second order, the value of a wider and lower kernel at the
    /// centroid. Sharpness is 1 / m^2 for Beckmann and the exponent for Phong. GGX stays as it is, since its tail does not widen like that.
    struct Softened {
        float sharpness, amplitude;
    };
    Softened softened(float spread) const;
};

/// Returns the scale of a kernel; m in (0, 1].
KernelScale makeKernelScale(PrefilterKernel kernel, double m);

namespace detail {

inline Float8 select(Int8 mask, Float8 yes, Float8 no) {
    return mask ? yes : no;
}

/// Returns 2^y for y <= 0, relative error 2e-7; flushes to about 1e-38 below -126.
inline Float8 exp2OfNegative(Float8 y) {
    const Float8 clamped = select(y < -126.0f, Float8{} - 126.0f, y);
    const Int8 whole = __builtin_convertvector(clamped - 0.5f, Int8);  // truncation of a negative number: the nearest integer of y
    const Float8 f = clamped - __builtin_convertvector(whole, Float8);
    Float8 p = f * 1.5252733804e-5f + 1.5403530394e-4f;  // Taylor: ln(2)^k / k!
    p = p * f + 1.3333558146e-3f;
    p = p * f + 9.6181291076e-3f;
    p = p * f + 5.5504108665e-2f;
    p = p * f + 2.4022650696e-1f;
    p = p * f + 6.9314718056e-1f;
    p = p * f + 1.0f;
    const Int8 bits = (whole + 127) << 23;
    return p * std::bit_cast<Float8>(bits);
}

/// Returns log2(1 - d) for d in [0, 1), accurate near d = 0, as narrow Phong lobes need.
inline Float8 log2OneMinus(Float8 d) {
    const Float8 c = 1.0f - d;
    const Int8 bits = std::bit_cast<Int8>(c);
    const Int8 exponent = (bits - 0x3f3504f3) >> 23;  // mantissa into [sqrt(1/2), sqrt(2))
    const Int8 mantissaBits = bits - (exponent << 23);
    const Float8 f = select(exponent == 0, Float8{} - d, std::bit_cast<Float8>(mantissaBits) - 1.0f);
    const Float8 t = f / (f + 2.0f), tt = t * t;  // log(1 + f) = 2 atanh(f / (2 + f))
    const Float8 series = (((tt * (1.0f / 9) + 1.0f / 7) * tt + 1.0f / 5) * tt + 1.0f / 3) * tt + 1.0f;
    return __builtin_convertvector(exponent, Float8) + t * series * 2.8853900818f;  // 2 / ln 2
}

}  // namespace detail

/// Returns the shape of the kernel (1 at the centre) at eight squared chords.
/// kNarrow    scale.isNarrow
/// sharpness  from KernelScale::softened
template <PrefilterKernel kKernel, bool kNarrow>
inline Float8 kernelShape(Float8 chordSquared, float sharpness, const KernelScale& scale) {
    using detail::select;
    const Float8 x = chordSquared * 0.25f;  // sin^2 of half the angle
    const Float8 c = 1.0f - 2.0f * x;
    const Float8 zero{};
    Float8 shape;
    if constexpr (kKernel == PrefilterKernel::Beckmann) {
        const Float8 inverse = 1.0f / (1.0f - (kNarrow ? x : select(x > 0.5f, zero + 0.5f, x)));
        shape = detail::exp2OfNegative(x * inverse * (sharpness * -1.4426950409f)) * (inverse * inverse) * c;
    } else if constexpr (kKernel == PrefilterKernel::Ggx) {
        const Float8 ratio = scale.mSquared / (scale.mSquared + x * scale.oneMinusMSquared);
        shape = ratio * ratio * c;
    } else if constexpr (kNarrow) {
        // ln(1 - 2x) = -2 atanh(t) with t = x / (1 - x), at most 0.25: the next term, t^11 / 11, is under 1e-7.
        const Float8 t = x / (1.0f - x), tt = t * t;
        const Float8 series = (((tt * (1.0f / 9) + 1.0f / 7) * tt + 1.0f / 5) * tt + 1.0f / 3) * tt + 1.0f;
        shape = detail::exp2OfNegative(t * series * (sharpness * -2.8853900818f));
    } else {
        const Float8 d = select(c > 1e-6f, 2.0f * x, zero + 0.999999f);
        shape = detail::exp2OfNegative(sharpness * detail::log2OneMinus(d));
    }
    return kNarrow ? shape : select(c > 0.0f, shape, zero);
}

}  // namespace lightcook::fit
