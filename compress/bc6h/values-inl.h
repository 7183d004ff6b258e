// BC6H: conversion between linear light, the scale v of the format, and the metric.
//
// Words: v is the scale on which the format interpolates: 0 .. 65535, or -32767 .. 32767 if signed. A decoder turns v into the bits of a
// half by v * 31/64 (31/32 if signed), so v is nearly the logarithm of light. A code is the stored integer of an endpoint. Both are exact
// in a float. The metric is the value whose squared differences are minimized (HdrMetric).
#if defined(LIGHTCOOK_COMPRESS_BC6H_VALUES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC6H_VALUES_INL_H_
#undef LIGHTCOOK_COMPRESS_BC6H_VALUES_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC6H_VALUES_INL_H_
#endif

#include <hwy/highway.h>

#include "compress/bc6h/search.h"
#include "compress/block/lanes-inl.h"
#include "compress/encode_options.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D, bool kSigned>
class Bc6hValues : Lanes<D> {
    using typename Lanes<D>::F, typename Lanes<D>::DI, typename Lanes<D>::I;
    using Lanes<D>::set;

public:
    explicit Bc6hValues(const EncodeOptions& options) : scale_(options.hdrScale), isLog_(options.hdrMetric == HdrMetric::Log) {}

    static constexpr float kLargest = kSigned ? 32767.0f : 65535.0f;
    static constexpr float kSmallest = kSigned ? -32767.0f : 0.0f;
    static constexpr float kPerHalf = kSigned ? 32.0f / 31 : 64.0f / 31;  ///< difference in v between neighbouring halves

    /// Returns the metric of light x. HdrMetric::Relative uses x itself; its scale is part of the weights.
    HWY_INLINE F metric(F x) const {
        if (!isLog_) return x;
        if constexpr (!kSigned) return log2(hn::MulAdd(x, set(1.0f / scale_), set(1.0f)));
        return hn::CopySign(log2(hn::MulAdd(hn::Abs(x), set(1.0f / scale_), set(1.0f))), x);
    }
    /// Returns the light that an interpolated integer v decodes to.
    static HWY_INLINE F lightOf(F v) {
        const I whole = hn::ConvertTo(DI(), kSigned ? hn::Abs(v) : v);
        const I half = hn::ShiftRight < kSigned ? 5 : 6 > (hn::ShiftLeft<5>(whole) - whole);
        const F x = hn::BitCast(D(), hn::ShiftLeft<13>(half)) * set(0x1p112f);
        return kSigned ? hn::CopySign(x, v) : x;
    }
    /// Returns the middle of the values v that decode to the half nearest to x; 0 for half 0.
    static HWY_INLINE F vOf(F x) {
        const F magnitude = hn::Abs(x);
        const I bits = hn::BitCast(DI(), magnitude);
        const I odd = hn::And(hn::ShiftRight<13>(bits), hn::Set(DI(), 1));
        const I normal = hn::ShiftRight<13>(bits + hn::Set(DI(), 0x0FFF - 0x38000000) + odd);
        const I denormal = hn::BitCast(DI(), magnitude + set(0.5f)) - hn::Set(DI(), 0x3F000000);
        const I half = hn::IfThenElse(hn::RebindMask(DI(), magnitude < set(0x1p-14f)), denormal, normal);
        const F v = (hn::ConvertTo(D(), half) + set(0.5f)) * set(kPerHalf);
        const F signedV = kSigned ? hn::CopySign(v, x) : v;
        return hn::IfThenElse(hn::RebindMask(D(), half == hn::Zero(DI())), hn::Zero(D()), signedV);
    }

private:
    /// Returns log2(z), z >= 1, to 2e-5: the exponent plus a polynomial of the mantissa.
    static HWY_INLINE F log2(F z) {
        const I bits = hn::BitCast(DI(), z);
        const F exponent = hn::ConvertTo(D(), hn::ShiftRight<23>(bits) - hn::Set(DI(), 127));
        const F m = hn::BitCast(D(), hn::Or(hn::And(bits, hn::Set(DI(), 0x7FFFFF)), hn::Set(DI(), 0x3F800000))) - set(1.0f);
        F p = set(kBc6hLog2[4]);
        for (std::size_t i = 4; i-- > 0;) p = hn::MulAdd(p, m, set(kBc6hLog2[i]));
        return hn::MulAdd(m, p, exponent);
    }

    float scale_;
    bool isLog_;
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
