// BC6H, fast kernel: loads the texels of neighbouring blocks into lanes, converts them to v (values-inl.h), and weights their errors.
#if defined(LIGHTCOOK_COMPRESS_BC6H_FAST_TEXELS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC6H_FAST_TEXELS_INL_H_
#undef LIGHTCOOK_COMPRESS_BC6H_FAST_TEXELS_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC6H_FAST_TEXELS_INL_H_
#endif

#include <hwy/highway.h>

#include <array>
#include <cstddef>

#include "compress/bc6h/values-inl.h"
#include "compress/block/block.h"
#include "compress/block/lanes-inl.h"
#include "compress/block/principal_axis-inl.h"
#include "compress/block/texel_rows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D, bool kSigned>
class Bc6hFastTexels : Lanes<D> {
    using typename Lanes<D>::F, typename Lanes<D>::M, typename Lanes<D>::DI, typename Lanes<D>::I;
    using Lanes<D>::set, Lanes<D>::zero, Lanes<D>::clamp, Lanes<D>::select;
    using Values = Bc6hValues<D, kSigned>;

public:
    F v[3][kTexelCount];          ///< in the scale of the format
    F low[3], high[3];            ///< range of v
    F weight[3][kTexelCount];     ///< weight of a squared error in v
    F significance[kTexelCount];  ///< as given, or 1 throughout an insignificant block
    M nothing;                    ///< insignificant blocks

    explicit Bc6hFastTexels(const EncodeOptions& options) : options_(options), isLinear_(options.hdrMetric == HdrMetric::Linear) {}

    /// Loads Lanes(d) blocks and sets all members. Returns true if a value was clamped into the range of the format.
    /// texels, weights  as for Bc6hFast::run
    bool load(const std::array<const float*, 4>& texels, const std::array<const float*, 4>* weights) {
        const bool clamped = loadLight(texels);
        if (weights)
            loadSignificance(*weights);
        else
            setUniform();
        weigh();
        return clamped;
    }

private:
    bool loadLight(const std::array<const float*, 4>& texels) {
        const D d;
        F lowest = zero(), highest = zero();
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            std::array<F, 3> x;
            loadTexel<D>(texels[t / 4] + 4 * (t % 4), x);
            for (std::size_t c = 0; c < 3; ++c) {
                lowest = hn::Min(lowest, x[c]);
                highest = hn::Max(highest, x[c]);
                v[c][t] = vOf(x[c]);
            }
        }
        const M below = lowest < set(kSigned ? -65504.0f : 0.0f);
        return !hn::AllFalse(d, hn::Or(below, highest > set(65504.0f)));
    }
    /// Returns v of a value, clamped to the range of the format. Unlike Bc6hValues::vOf, zero gives half a step, which decodes to zero too.
    static HWY_INLINE F vOf(F x) {
        const F magnitude = hn::Min(kSigned ? hn::Abs(x) : hn::Max(x, zero()), set(65504.0f));
        // 2^-112 moves the exponent to that of a half, denormals included. The bits from the thirteenth up are then the half.
        const F half = hn::Round(hn::ConvertTo(D(), bitsOf(magnitude * set(0x1p-112f))) * set(0x1p-13f));
        const F v = hn::MulAdd(half, set(Values::kPerHalf), set(Values::kPerHalf / 2));
        return kSigned ? hn::CopySign(v, x + zero()) : v;
    }

    void setUniform() {
        for (F& s : significance) s = set(1.0f);
        nothing = set(1.0f) < zero();
    }
    /// Replaces texels of significance 0 by a significant one of their block. All texels of an insignificant block count.
    void loadSignificance(const std::array<const float*, 4>& weights) {
        loadWeights<D>(weights, significance, nothing);
        M all = zero() == zero();
        for (const F& s : significance) all = hn::And(all, s > zero());
        if (hn::AllTrue(D(), all)) return;
        F stand[3] = {zero(), zero(), zero()};
        for (int t = 0; t < kTexelCount; ++t)
            for (int c = 0; c < 3; ++c) stand[c] = select(significance[t] > zero(), v[c][t], stand[c]);
        for (int t = 0; t < kTexelCount; ++t)
            for (int c = 0; c < 3; ++c) v[c][t] = select(significance[t] > zero(), v[c][t], stand[c]);
    }

    /// Sets the weights of squared errors in v: the square of the slope of the metric. The slope is taken a little above the texel: at 0 it
    /// is almost 0, and dark texels beside bright ones would have almost no weight.
    void weigh() {
        for (int c = 0; c < 3; ++c) {
            low[c] = high[c] = v[c][0];
            for (int t = 1; t < kTexelCount; ++t) {
                low[c] = hn::Min(low[c], v[c][t]);
                high[c] = hn::Max(high[c], v[c][t]);
            }
            const F reach = hn::MulAdd(high[c] - low[c], set(1.0f / 16), set(64.0f));
            const F channelWeight = set(options_.channelWeights[static_cast<std::size_t>(c)]);
            for (int t = 0; t < kTexelCount; ++t) {
                const F above = hn::Min((kSigned ? hn::Abs(v[c][t]) : v[c][t]) + reach, set(Values::kLargest));
                const F x = floatOf(hn::ConvertTo(DI(), above * set(8192 / Values::kPerHalf))) * set(0x1p112f);
                const F slope = isLinear_ ? x * set(1.0f / 65504) : x * roughInverse<D>(x + set(options_.hdrScale));
                weight[c][t] = significance[t] * channelWeight * (slope * slope);
            }
        }
    }

    static HWY_INLINE I bitsOf(F value) { return hn::BitCast(DI(), value); }
    static HWY_INLINE F floatOf(I bits) { return hn::BitCast(D(), bits); }

    const EncodeOptions& options_;
    bool isLinear_;
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
