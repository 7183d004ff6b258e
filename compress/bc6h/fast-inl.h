// BC6H at low effort: one region, one block in each lane, from rows of texels to packed blocks without gathering blocks.
//
// Method: a line in v along the principal axis, one least-squares refit to the nearest indices, the finest one-region mode that holds its
// ends, indices for the rounded ends. No search. The kernel estimates the error of each block from the slopes of the metric, and reports
// infinity where the slopes are not reliable; blocks above a limit are encoded again by the full search (Bc6hSearch::fastKernelMaxError).
#if defined(LIGHTCOOK_COMPRESS_BC6H_FAST_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC6H_FAST_INL_H_
#undef LIGHTCOOK_COMPRESS_BC6H_FAST_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC6H_FAST_INL_H_
#endif

#include <hwy/highway.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "compress/bc6h/fast_block-inl.h"
#include "compress/bc6h/fast_line-inl.h"
#include "compress/bc6h/fast_texels-inl.h"
#include "compress/bc6h/values-inl.h"
#include "compress/block/block.h"
#include "compress/block/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D, bool kSigned>
class Bc6hFast : Lanes<D> {
    using typename Lanes<D>::F, typename Lanes<D>::M;
    using Lanes<D>::set, Lanes<D>::zero, Lanes<D>::select;
    using Values = Bc6hValues<D, kSigned>;
    // Limits of a reliable estimate, in octaves of v, where all denormals of a half are one octave.
    static constexpr float kWide = 4;               ///< largest range of a channel, with the logarithmic metric
    static constexpr float kWideElsewhere = 1;      ///< the same with other metrics
    static constexpr float kDark = 2;               ///< a block with a value below it is dark
    static constexpr float kDarkRange = 1.0f / 64;  ///< largest range of a channel of a dark block

public:
    explicit Bc6hFast(const EncodeOptions& options) : options_(options), texels_(options) {}

    /// Encodes Lanes(d) blocks.
    /// texels   four rows of 4 Lanes(d) texels of four floats
    /// weights  four rows of significance, or null for 1 everywhere
    /// out      four words per block
    /// errors   receives the mean squared error of each block [octaves^2], approximately; infinity where it is not reliable. May be null
    /// Returns true if a value was clamped into the range of the format.
    bool run(const std::array<const float*, 4>& texels, const std::array<const float*, 4>* weights, std::uint32_t* out, float* errors) {
        const bool clamped = texels_.load(texels, weights);
        line_.fit(texels_);
        block_.quantize(line_);
        line_.chooseIndices(texels_);
        block_.pack(line_.index, out);
        if (errors) hn::StoreU(estimateError(), D(), errors);
        return clamped;
    }

private:
    /// Estimates the mean squared error [octaves^2]; 0 for insignificant blocks. Returns infinity where the slopes of the metric are not
    /// reliable, and where one colour would have a smaller error.
    F estimateError() const {
        F error = zero(), range = zero(), darkest = set(Values::kLargest), total = zero();
        for (const F& s : texels_.significance) total = total + s;
        for (int c = 0; c < 3; ++c) {
            for (int t = 0; t < kTexelCount; ++t) {
                const F away = hn::NegMulAdd(line_.d[c], line_.index[t] * set(1.0f / 15), texels_.v[c][t] - line_.a[c]);
                error = hn::MulAdd(texels_.weight[c][t] * away, away, error);
            }
            range = hn::Max(range, texels_.high[c] - texels_.low[c]);
            // The magnitude nearest to 0 in the channel, 0 where signs differ. Above effort 0, blocks with negative values count as dark,
            // and go to the full search, which is better by 0.1 dB there.
            const F nearest = hn::Max(hn::Max(texels_.low[c], zero() - texels_.high[c]), zero());
            darkest = hn::Min(darkest, kSigned && options_.effort == 0 ? nearest : texels_.low[c]);
        }
        constexpr float kOctave = 1024 * Values::kPerHalf;
        const M dark = hn::And(darkest<set(kDark * kOctave), range> set(kDarkRange * kOctave));
        const float wide = (options_.hdrMetric == HdrMetric::Log ? kWide : kWideElsewhere) * kOctave;
        const M unreliable = hn::Or(hn::Or(dark, range > set(wide)), hn::And(error > line_.oneColour, range > zero()));
        error = hn::IfThenZeroElse(texels_.nothing, error / (total * set(3 * kOctave * kOctave)));
        return select(unreliable, set(std::numeric_limits<float>::infinity()), error);
    }

    const EncodeOptions& options_;
    Bc6hFastTexels<D, kSigned> texels_;
    Bc6hFastLine<D, kSigned> line_;
    Bc6hFastBlock<D, kSigned> block_;
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
