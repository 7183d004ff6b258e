// BC6H's own scale, the metric, and the way between them, in lanes.
//
// Words: v is the scale on which the format interpolates: 0 .. 65535, or -32767 .. 32767 if signed. Nearly the bits of a half, times 64/31
// (or 32/31), so nearly the logarithm of light. A code is an endpoint's stored integer. All of them fit a float exactly.
#if defined(LIGHTCOOK_COMPRESS_BC6H_VALUES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC6H_VALUES_INL_H_
#undef LIGHTCOOK_COMPRESS_BC6H_VALUES_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC6H_VALUES_INL_H_
#endif

#include <hwy/highway.h>

#include "compress/bc6h/search.h"
#include "compress/encode.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D, bool kSigned>
class Bc6hValues {
    using F = hn::Vec<D>;
    using DI = hn::RebindToSigned<D>;
    using I = hn::Vec<DI>;

public:
    explicit Bc6hValues(const EncodeOptions& options) : scale_(options.hdrScale), isLog_(options.hdrMetric == HdrMetric::Log) {}

    static constexpr float kLargest = kSigned ? 32767.0f : 65535.0f;
    static constexpr float kSmallest = kSigned ? -32767.0f : 0.0f;
    static constexpr float kPerHalf = kSigned ? 32.0f / 31 : 64.0f / 31;  ///< v between one half and the next

    /// The value whose squared differences are minimised, of light x.
    HWY_INLINE F metric(F x) const {
        if (!isLog_) return x;
        if constexpr (!kSigned) return log2(x * set(1.0f / scale_) + set(1.0f));
        return hn::CopySign(log2(hn::Abs(x) * set(1.0f / scale_) + set(1.0f)), x);
    }
    /// Light that an interpolated, whole v decodes to.
    static HWY_INLINE F lightOf(F v) {
        const I whole = hn::ConvertTo(DI(), kSigned ? hn::Abs(v) : v);
        const I half = hn::ShiftRight < kSigned ? 5 : 6 > (hn::ShiftLeft<5>(whole) - whole);
        const F x = hn::BitCast(D(), hn::ShiftLeft<13>(half)) * set(0x1p112f);
        return kSigned ? hn::CopySign(x, v) : x;
    }
    /// Middle of the vs that decode to the half nearest to x.
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
    static HWY_INLINE F set(float value) { return hn::Set(D(), value); }

    /// log2(z) for z >= 1 to 2e-5: exponent, and a polynomial in the mantissa.
    static HWY_INLINE F log2(F z) {
        const I bits = hn::BitCast(DI(), z);
        const F exponent = hn::ConvertTo(D(), hn::ShiftRight<23>(bits) - hn::Set(DI(), 127));
        const F m = hn::BitCast(D(), hn::Or(hn::And(bits, hn::Set(DI(), 0x7FFFFF)), hn::Set(DI(), 0x3F800000))) - set(1.0f);
        F p = set(kBc6hLog2[4]);
        for (std::size_t i = 4; i-- > 0;) p = p * m + set(kBc6hLog2[i]);
        return exponent + m * p;
    }

    float scale_;
    bool isLog_;
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
