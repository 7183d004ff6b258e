// BC4: the texels of one channel of as many blocks as a vector has lanes, and the error that a pair of endpoints leaves.
//
// Words: values are in codes, 0 .. codes.largest. The endpoints low <= high are codes too. A palette has equidistant entries from low to
// high, which are counted in steps: 7 steps in the eight-value mode; 5 steps in the six-value mode, whose palette also holds the smallest
// and the largest code exactly.
#if defined(LIGHTCOOK_COMPRESS_BC4_TEXELS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC4_TEXELS_INL_H_
#undef LIGHTCOOK_COMPRESS_BC4_TEXELS_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC4_TEXELS_INL_H_
#endif

#include <hwy/highway.h>

#include "compress/bc4/search.h"
#include "compress/block/block.h"
#include "compress/block/lanes-inl.h"
#include "compress/block/weights-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// A pair of endpoints and its weighted squared error.
template <class D>
struct Bc4Candidate {
    hn::Vec<D> error, low, high;

    /// Returns a where the mask is set, else b.
    static HWY_INLINE Bc4Candidate choose(hn::Mask<D> mask, const Bc4Candidate& a, const Bc4Candidate& b) {
        return {hn::IfThenElse(mask, a.error, b.error), hn::IfThenElse(mask, a.low, b.low), hn::IfThenElse(mask, a.high, b.high)};
    }
};

template <class D>
class Bc4Texels : Lanes<D> {
    using typename Lanes<D>::F, typename Lanes<D>::M;
    using Lanes<D>::set, Lanes<D>::clamp;

public:
    using Candidate = Bc4Candidate<D>;

    /// Weighted sums over the texels that are fitted to the equidistant entries. Values count from the block's lowest value.
    struct Moments {
        F total, perTotal, meanV, vv;  ///< vv: squared distances from the mean
        F left;                        ///< error of the other texels, which take the smallest or the largest code
    };

    F value[kTexelCount], weight[kTexelCount];
    F above[kTexelCount];    ///< value minus lowest
    F nearEnd[kTexelCount];  ///< distance from the smallest or the largest code, whichever is nearer; set by measureExtremes
    F lowest, highest;       ///< range of the significant texels
    F leastNear;             ///< smallest error of any single texel that takes the smallest or the largest code; likewise
    Moments all;             ///< of all texels
    bool isUniform;          ///< every weight in every lane is 1

    explicit Bc4Texels(const Bc4Codes& codes) : codes_(codes) {}

    template <bool kSix>
    static constexpr float steps() {
        return kSix ? 5.0f : 7.0f;
    }
    HWY_INLINE F largest() const { return set(codes_.largest); }
    const Bc4Codes& codes() const { return codes_; }
    /// Returns a candidate that any other one beats.
    Candidate nothing() const { return {set(1e30f), set(0.0f), largest()}; }

    /// Loads one channel of Lanes(d) blocks.
    void load(const Block* const* blocks, std::size_t channel) {
        const D d;
        HWY_ALIGN float buffer[hn::MaxLanes(D())];
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) buffer[lane] = blocks[lane]->channel[channel][t];
            value[t] = hn::Load(d, buffer) * set(codes_.scale) + set(codes_.offset);
            for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) buffer[lane] = blocks[lane]->significance[t];
            weight[t] = hn::Load(d, buffer);
        }
        measure(false);
    }
    /// Takes values in the range of the format, and weights, that are in lanes already.
    /// weightsAreOne  all weights are known to be 1
    void load(const F (&formatValue)[kTexelCount], const F (&texelWeight)[kTexelCount], bool weightsAreOne) {
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            value[t] = formatValue[t] * set(codes_.scale) + set(codes_.offset);
            weight[t] = texelWeight[t];
        }
        measure(weightsAreOne);
    }

    /// Prepares for the six-value mode.
    void measureExtremes() {
        leastNear = set(1e30f);
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            nearEnd[t] = hn::Min(value[t], largest() - value[t]);
            const F error = weight[t] * nearEnd[t] * nearEnd[t];
            leastNear = hn::IfThenElse(weight[t] > set(0.0f), hn::Min(leastNear, error), leastNear);
        }
    }

    /// Returns the step of texel t that is nearest to its value, and the distance in miss. Fused operations save instructions.
    template <bool kSix>
    HWY_INLINE F place(F low, F unit, F scale, std::size_t t, F& miss) const {
        const F aboveLow = value[t] - low;
        const F step = hn::Round(clamp(aboveLow * scale, set(0.0f), set(steps<kSix>())));
        miss = hn::NegMulAdd(step, unit, aboveLow);
        return step;
    }

    /// Returns the weighted squared error, with each texel at its nearest palette entry.
    template <bool kSix>
    HWY_INLINE F errorOf(F low, F high) const {
        return isUniform ? errorWith<kSix>(Ones{}, low, high) : errorWith<kSix>(Weights{weight}, low, high);
    }

    /// Returns the moments of the texels under these weights.
    Moments momentsOf(const F* weights) const { return momentsWith(Weights{weights}); }

    /// Assigns each texel its nearest step k between two ends, which need not be codes, and sums k, k^2 and k v, v the value above lowest.
    template <bool kSix>
    HWY_INLINE void sumSteps(const F* weights, F from, F to, F& sumK, F& sumKk, F& sumKv) const {
        if (isUniform && weights == weight)
            sumStepsWith<kSix>(Ones{}, from, to, sumK, sumKk, sumKv);
        else
            sumStepsWith<kSix>(Weights{weights}, from, to, sumK, sumKk, sumKv);
    }

private:
    using Ones = UnitWeights<D>;
    using Weights = TexelWeights<D>;

    void measure(bool weightsAreOne) {
        isUniform = weightsAreOne || areUnitWeights(D(), weight);
        if (isUniform)
            measureWith(Ones{});
        else
            measureWith(Weights{weight});
    }

    template <class W>
    void measureWith(const W& weights) {
        lowest = largest();
        highest = set(0.0f);
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            lowest = weights.ifCounts(t, hn::Min(lowest, value[t]), lowest);
            highest = weights.ifCounts(t, hn::Max(highest, value[t]), highest);
        }
        for (std::size_t t = 0; t < kTexelCount; ++t) above[t] = value[t] - lowest;
        all = momentsWith(weights);
    }

    template <class W>
    Moments momentsWith(const W& weights) const {
        Moments m = {set(1e-30f), set(0.0f), set(0.0f), set(0.0f), set(0.0f)};
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            m.total = m.total + weights.times(t, set(1.0f));
            m.meanV = m.meanV + weights.times(t, above[t]);
        }
        m.perTotal = set(1.0f) / m.total;
        m.meanV = m.meanV * m.perTotal;
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            const F v = above[t] - m.meanV;
            m.vv = hn::MulAdd(weights.times(t, v), v, m.vv);
        }
        return m;
    }

    /// Computes distances in steps and scales the sum to codes at the end.
    template <bool kSix, class W>
    HWY_INLINE F errorWith(const W& weights, F low, F high) const {
        constexpr float kSteps = steps<kSix>();
        const F range = hn::Max(high - low, set(0x1p-20f)), scale = set(kSteps) / range, unit = range * set(1 / kSteps);
        const F offset = (lowest - low) * scale;
        F error = set(0.0f);
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            const F at = hn::MulAdd(above[t], scale, offset);
            F miss = at - hn::Round(clamp(at, set(0.0f), set(kSteps)));
            if constexpr (kSix) miss = hn::Min(hn::Abs(miss), nearEnd[t] * scale);
            error = hn::MulAdd(weights.times(t, miss), miss, error);
        }
        return error * unit * unit;
    }

    template <bool kSix, class W>
    HWY_INLINE void sumStepsWith(const W& weights, F from, F to, F& sumK, F& sumKk, F& sumKv) const {
        const F scale = set(steps<kSix>()) / hn::Max(to - from, set(0.0625f)), offset = (lowest - from) * scale;
        sumK = sumKk = sumKv = set(0.0f);
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            const F k = hn::Round(clamp(hn::MulAdd(above[t], scale, offset), set(0.0f), set(steps<kSix>())));
            const F weighted = weights.times(t, k);
            sumK = sumK + weighted;
            sumKk = hn::MulAdd(weighted, k, sumKk);
            sumKv = hn::MulAdd(weighted, above[t], sumKv);
        }
    }

    const Bc4Codes codes_;
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
