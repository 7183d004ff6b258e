// BC6H: the texels of as many blocks as a vector has lanes, in three scales, and the weights of their errors.
//
// The error that counts is weighted and squared in the metric. Lines are fitted in v, the scale of the format (values-inl.h), so a squared
// error in v needs the weight  w = significance * channelWeight * (d metric / d v)^2.  The slope is a secant over the expected error,
// not the derivative at the texel: at 0 the derivative is almost 0, and dark texels beside bright ones would have almost no weight.
#if defined(LIGHTCOOK_COMPRESS_BC6H_TEXELS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC6H_TEXELS_INL_H_
#undef LIGHTCOOK_COMPRESS_BC6H_TEXELS_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC6H_TEXELS_INL_H_
#endif

#include <hwy/highway.h>

#include <cmath>
#include <cstring>

#include "compress/bc6h/values-inl.h"
#include "compress/block/block.h"
#include "compress/block/lanes-inl.h"
#include "compress/block/principal_axis-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D, bool kSigned>
class Bc6hTexels : Lanes<D> {
    using typename Lanes<D>::F, typename Lanes<D>::M;
    using Lanes<D>::set, Lanes<D>::zero, Lanes<D>::clamp, Lanes<D>::select;
    using Values = Bc6hValues<D, kSigned>;

public:
    static constexpr float kNear = 64.0f;  ///< smallest distance over which a slope is taken [v]

    F light[3][kTexelCount];        ///< linear, as given
    F target[3][kTexelCount];       ///< in v
    F value[3][kTexelCount];        ///< in the metric
    F errorWeight[3][kTexelCount];  ///< weight of a squared error in the metric
    F fitWeight[3][kTexelCount];    ///< weight of a squared error in v; the largest of a block is 1
    F startWeight[3][kTexelCount];  ///< the same for the first fit, when the error of the line is not known yet
    F weightScale;                  ///< factor by which fitWeight was normalized
    F significance[kTexelCount];
    /// Space in which partitions are ranked: the metric, channels scaled by the root of their weight, around the mean.
    F estimate[3][kTexelCount], estimateWeight[kTexelCount];

    Bc6hTexels(const Bc6hSearch& search, const EncodeOptions& options) : search_(search), options_(options), values_(options) {}

    const Values& values() const { return values_; }

    /// Loads Lanes(d) blocks.
    void load(const Block* const* blocks) {
        loadLight(blocks);
        for (int c = 0; c < 3; ++c) {
            low_[c] = set(1e30f), high_[c] = set(-1e30f);
            for (int t = 0; t < kTexelCount; ++t) {
                const M counts = significance[t] > zero();
                target[c][t] = Values::vOf(light[c][t]);
                value[c][t] = values_.metric(light[c][t]);
                low_[c] = select(counts, hn::Min(low_[c], target[c][t]), low_[c]);
                high_[c] = select(counts, hn::Max(high_[c], target[c][t]), high_[c]);
            }
        }
        for (int c = 0; c < 3; ++c) {
            weigh(c, low_[c], high_[c]);
            weighStart(c, low_[c], high_[c]);
        }
        normalizeWeights();
        setEstimate();
    }

    /// Raises startWeight in blocks of dim light beside black, as at the border of a chart: their range is less than an octave of the
    /// metric, but its slope is almost 0 at black, so that black texels would have almost no weight in the first fit. Returns false, and
    /// changes nothing, if no lane holds such a block.
    bool raiseStart() {
        M black = set(1.0f) < zero();
        for (int t = 0; t < kTexelCount; ++t) {
            const F largest = hn::Max(hn::Max(hn::Abs(target[0][t]), hn::Abs(target[1][t])), hn::Abs(target[2][t]));
            black = hn::Or(black, hn::And(significance[t] > zero(), largest < set(kNear)));
        }
        const F range = hn::Max(hn::Max(high_[0] - low_[0], high_[1] - low_[1]), high_[2] - low_[2]);
        black = hn::And(black, range > set(kWide));
        if (hn::AllFalse(D(), black)) return false;
        std::memcpy(savedStartWeight_, startWeight, sizeof(startWeight));
        for (int c = 0; c < 3; ++c) raiseWhere(black, c, low_[c], high_[c], weightScale);
        return true;
    }
    /// Undoes raiseStart().
    void restoreStart() { std::memcpy(startWeight, savedStartWeight_, sizeof(startWeight)); }

private:
    static constexpr float kOctave = 1.0f;                       ///< of the logarithmic metric
    static constexpr float kWide = 8 * 1024 * Values::kPerHalf;  ///< eight octaves [v]

    void loadLight(const Block* const* blocks) {
        const D d;
        const std::size_t lanes = hn::Lanes(d);
        HWY_ALIGN float buffer[hn::MaxLanes(D())];
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            for (std::size_t lane = 0; lane < lanes; ++lane) buffer[lane] = blocks[lane]->significance[t];
            significance[t] = hn::Load(d, buffer);
            for (std::size_t c = 0; c < 3; ++c) {
                for (std::size_t lane = 0; lane < lanes; ++lane) buffer[lane] = blocks[lane]->channel[c][t];
                // Adding zero turns -0 into 0, whose bits an unsigned block can hold.
                light[c][t] = hn::Load(d, buffer) + zero();
            }
        }
    }

    /// Sets errorWeight and fitWeight of a channel. The slope of the metric is a central difference over a share of the block's range.
    void weigh(int c, F low, F high) {
        const F reach = hn::Max((high - low) * set(search_.slopeReach), set(kNear));
        const F channelWeight = set(options_.channelWeights[static_cast<std::size_t>(c)]);
        for (int t = 0; t < kTexelCount; ++t) {
            const F below = clamp(target[c][t] - reach, set(Values::kSmallest), set(Values::kLargest));
            const F above = clamp(target[c][t] + reach, set(Values::kSmallest), set(Values::kLargest));
            const F rise = values_.metric(Values::lightOf(hn::Floor(above))) - values_.metric(Values::lightOf(hn::Floor(below)));
            const F slope = rise * roughInverse<D>(above - below);
            F weight = significance[t] * channelWeight;
            if (options_.hdrMetric == HdrMetric::Relative) {
                const F unit = hn::Abs(light[c][t]) + set(options_.hdrScale);
                weight = weight / (unit * unit);
            }
            errorWeight[c][t] = weight;
            fitWeight[c][t] = weight * slope * slope;
        }
    }

    /// Sets startWeight of a channel. The slope at a dark texel understates the cost of decoding it as a bright one. So in a block that
    /// holds both, the first fit uses the secant to the far end of the block's range where that is steeper. In other blocks, and in refits,
    /// this would cost 0.1 dB.
    void weighStart(int c, F low, F high) {
        const F rise = values_.metric(Values::lightOf(hn::Floor(high))) - values_.metric(Values::lightOf(hn::Floor(low)));
        const bool isLog = options_.hdrMetric == HdrMetric::Log;
        for (int t = 0; t < kTexelCount; ++t) startWeight[c][t] = fitWeight[c][t];
        raiseWhere(isLog ? rise > set(kOctave) : high - low > set(Values::kLargest / 4), c, low, high, set(1.0f));
    }

    /// Raises startWeight of a channel to that of the secant to the far end of the block, times a scale, where that is more.
    void raiseWhere(M mask, int c, F low, F high, F scale) {
        if (hn::AllFalse(D(), mask)) return;
        const F lowest = values_.metric(Values::lightOf(hn::Floor(low))), highest = values_.metric(Values::lightOf(hn::Floor(high)));
        for (int t = 0; t < kTexelCount; ++t) {
            const F toLow = (value[c][t] - lowest) * roughInverse<D>(hn::Max(target[c][t] - low, set(kNear)));
            const F toHigh = (highest - value[c][t]) * roughInverse<D>(hn::Max(high - target[c][t], set(kNear)));
            const F steepest = hn::Max(toLow, toHigh);
            const F raised = hn::Max(startWeight[c][t], errorWeight[c][t] * scale * steepest * steepest);
            startWeight[c][t] = select(mask, raised, startWeight[c][t]);
        }
    }

    /// Scales the weights so that the largest is 1: only ratios matter to a fit, and products must not underflow.
    void normalizeWeights() {
        F largest = set(1e-30f);
        for (int c = 0; c < 3; ++c)
            for (int t = 0; t < kTexelCount; ++t) largest = hn::Max(largest, fitWeight[c][t]);
        weightScale = set(1.0f) / largest;
        for (int c = 0; c < 3; ++c)
            for (int t = 0; t < kTexelCount; ++t) {
                fitWeight[c][t] = fitWeight[c][t] * weightScale;
                startWeight[c][t] = startWeight[c][t] * weightScale;
            }
    }

    /// Sets estimate and estimateWeight.
    void setEstimate() {
        F total = zero(), mean[3] = {zero(), zero(), zero()};
        for (int t = 0; t < kTexelCount; ++t) {
            estimateWeight[t] = significance[t];
            if (options_.hdrMetric == HdrMetric::Relative) {
                const F unit =
                    (hn::Abs(light[0][t]) + hn::Abs(light[1][t]) + hn::Abs(light[2][t])) * set(1.0f / 3) + set(options_.hdrScale);
                estimateWeight[t] = significance[t] / (unit * unit);
            }
            total = total + estimateWeight[t];
            for (std::size_t c = 0; c < 3; ++c) {
                estimate[c][t] = value[c][t] * set(std::sqrt(options_.channelWeights[c]));
                mean[c] = mean[c] + estimateWeight[t] * estimate[c][t];
            }
        }
        const F perTotal = set(1.0f) / total;
        for (int c = 0; c < 3; ++c)
            for (int t = 0; t < kTexelCount; ++t) estimate[c][t] = estimate[c][t] - mean[c] * perTotal;
    }

    const Bc6hSearch& search_;
    const EncodeOptions& options_;
    Values values_;
    F low_[3], high_[3];                  ///< range of the significant texels, in v
    F savedStartWeight_[3][kTexelCount];  ///< see raiseStart()
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
