// BC6H: the texels of as many blocks as a vector has lanes, what errors in them weigh, and lines through them.
#if defined(LIGHTCOOK_COMPRESS_BC6H_LINES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC6H_LINES_INL_H_
#undef LIGHTCOOK_COMPRESS_BC6H_LINES_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC6H_LINES_INL_H_
#endif

#include <hwy/highway.h>

#include <cstring>

#include "compress/bc6h/regions-inl.h"
#include "compress/bc6h/values-inl.h"
#include "compress/block/principal_axis-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D, bool kSigned>
class Bc6hLines {
    using F = hn::Vec<D>;
    using DI = hn::RebindToSigned<D>;
    using I = hn::Vec<DI>;
    using M = hn::Mask<D>;
    using Values = Bc6hValues<D, kSigned>;

public:
    using Line = Bc6hLine<D>;
    using Texels = F[kTexelCount];

    Bc6hLines(const Bc6hSearch& search, const EncodeOptions& options) : search_(search), options_(options), values_(options) {}

    void load(const Block* const* blocks) {
        const D d;
        const std::size_t lanes = hn::Lanes(d);
        HWY_ALIGN float buffer[hn::MaxLanes(D())];
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            for (std::size_t lane = 0; lane < lanes; ++lane) buffer[lane] = blocks[lane]->significance[t];
            significance_[t] = hn::Load(d, buffer);
            for (std::size_t c = 0; c < 3; ++c) {
                for (std::size_t lane = 0; lane < lanes; ++lane) buffer[lane] = blocks[lane]->channel[c][t];
                // Adding zero turns -0 into 0, whose bits an unsigned block can hold.
                light_[c][t] = hn::Load(d, buffer) + zero();
            }
        }
        for (int c = 0; c < 3; ++c) {
            F low = set(1e30f), high = set(-1e30f);
            for (int t = 0; t < kTexelCount; ++t) {
                const M counts = significance_[t] > zero();
                target_[c][t] = Values::vOf(light_[c][t]);
                value_[c][t] = values_.metric(light_[c][t]);
                low = select(counts, hn::Min(low, target_[c][t]), low);
                high = select(counts, hn::Max(high, target_[c][t]), high);
            }
            weigh(c, low, high);
        }
        normalizeWeights();
        estimateSpace();
        axisSpace();
    }

    /// The space in which partitions are judged, channel by channel: the metric's, around the mean.
    const Texels* estimate() const { return estimate_; }
    const Texels& estimateWeight() const { return estimateWeight_; }

    /// Lines along the principal axes; errors weigh by the slopes of the metric until errorOf knows better.
    template <class Regions>
    void start(const Regions& regions, Line* lines) {
        Texels position;
        startPositions(regions, position);
        leastSquares(regions, position, startWeight_, lines);
        std::memcpy(refitWeight_, fitWeight_, sizeof(fitWeight_));
    }
    template <class Regions>
    void refitFree(const Regions& regions, Texels& index, Line* lines) const {
        constexpr float kSteps = Regions::kSteps;
        for (int t = 0; t < kTexelCount; ++t) {
            F a[3], d[3];
            lineAt(regions, lines, t, a, d);
            index[t] = hn::Round(clamp(positionOn(a, d, t) * set(kSteps), zero(), set(kSteps)));
        }
        refit(regions, index, lines);
    }

    template <class Regions>
    void refit(const Regions& regions, const Texels& index, Line* lines) const {
        Texels position;
        for (int t = 0; t < kTexelCount; ++t) position[t] = regions.weightOfIndex(index[t]) * set(1.0f / 64);
        leastSquares(regions, position, refitWeight_, lines);
    }

    /// Turns lines round where their anchor lies beyond the middle: its index is stored without the highest bit.
    template <class Regions>
    void orient(const Regions& regions, Line* lines) const {
        turnWhere(positionOn(lines[0].a, lines[0].d, 0) > set(0.5f), lines[0]);
        if constexpr (Regions::kCount == 2) {
            F position = zero();
            for (int i = 0; i < 3; ++i)
                position = select(regions.anchorAt[i], positionOn(lines[1].a, lines[1].d, Regions::kAnchors[i]), position);
            turnWhere(position > set(0.5f), lines[1]);
        }
    }

    /// Nearest index of each texel. Anchors keep to the lower half.
    template <class Regions>
    void chooseIndices(const Regions& regions, const Line* lines, Texels& index) const {
        constexpr float kSteps = Regions::kSteps;
        for (int t = 0; t < kTexelCount; ++t) {
            F a[3], d[3];
            lineAt(regions, lines, t, a, d);
            index[t] = hn::Round(clamp(positionOn(a, d, t) * set(kSteps), zero(), set(kSteps)));
        }
        keepAnchorsLow(regions, index);
    }

    /// Error of whole-numbered lines in the metric, to the bit as a decoder sees them. Reweigh: std::true_type if refits are to weigh
    /// errors by what these cost.
    template <class Regions, class Reweigh>
    F errorOf(const Regions& regions, const Line* lines, const Texels& index, Reweigh) {
        F error = zero();
        for (int t = 0; t < kTexelCount; ++t) {
            F a[3], d[3];
            lineAt(regions, lines, t, a, d);
            const F weight = regions.weightOfIndex(index[t]);
            for (int c = 0; c < 3; ++c) {
                const F v = interpolate(a[c], d[c], weight);
                const F miss = values_.metric(Values::lightOf(v)) - value_[c][t];
                const F squared = errorWeight_[c][t] * miss * miss;
                error = error + squared;
                if constexpr (Reweigh::value) {
                    const F away = v - target_[c][t];
                    const F secant = squared * weightScale_ / hn::Max(away * away, set(kNear * kNear));
                    refitWeight_[c][t] = fitWeight_[c][t] * set(0.3f) + secant * set(0.7f);
                }
            }
        }
        return error;
    }

    /// Error of one colour for all texels, the weighted mean in the metric. mean receives it.
    F oneColourError(F (&mean)[3]) const {
        F error = zero();
        for (int c = 0; c < 3; ++c) {
            F total = set(1e-30f), sum = zero();
            for (int t = 0; t < kTexelCount; ++t) {
                total = total + errorWeight_[c][t];
                sum = sum + errorWeight_[c][t] * value_[c][t];
            }
            mean[c] = sum / total;
            for (int t = 0; t < kTexelCount; ++t) {
                const F miss = value_[c][t] - mean[c];
                error = error + errorWeight_[c][t] * miss * miss;
            }
        }
        return error;
    }

    /// The whole v whose light is nearest to a value in the metric, by halving what is left.
    F wholeVOf(F value) const {
        F low = set(Values::kSmallest), high = set(Values::kLargest);
        for (int i = 0; i < 17; ++i) {
            const F middle = hn::Floor((low + high) * set(0.5f));
            const M above = values_.metric(Values::lightOf(middle)) > value;
            low = select(above, low, middle);
            high = select(above, middle, high);
        }
        const F under = value - values_.metric(Values::lightOf(low)), over = values_.metric(Values::lightOf(high)) - value;
        return select(hn::Abs(under) <= hn::Abs(over), low, high);
    }

private:
    static constexpr float kNear = 64.0f;
    static constexpr float kOctave = 1.0f;

    static HWY_INLINE F set(float value) { return hn::Set(D(), value); }
    static HWY_INLINE F zero() { return hn::Zero(D()); }
    static HWY_INLINE F clamp(F value, F low, F high) { return hn::Min(hn::Max(value, low), high); }
    static HWY_INLINE F select(M mask, F yes, F no) { return hn::IfThenElse(mask, yes, no); }

    /// Weights of a squared error in v: the slope of the metric, squared, measured across the error that is to be expected. The slope at
    /// the texel itself would be next to nothing at 0, and leave the dark beside a light to chance.
    void weigh(int c, F low, F high) {
        const F reach = hn::Max((high - low) * set(search_.slopeReach), set(64.0f));
        const F channelWeight = set(options_.channelWeights[static_cast<std::size_t>(c)]);
        for (int t = 0; t < kTexelCount; ++t) {
            const F below = clamp(target_[c][t] - reach, set(Values::kSmallest), set(Values::kLargest));
            const F above = clamp(target_[c][t] + reach, set(Values::kSmallest), set(Values::kLargest));
            const F slope =
                (values_.metric(Values::lightOf(hn::Floor(above))) - values_.metric(Values::lightOf(hn::Floor(below)))) / (above - below);
            F weight = significance_[t] * channelWeight;
            if (options_.hdrMetric == HdrMetric::Relative) {
                const F unit = hn::Abs(light_[c][t]) + set(options_.hdrScale);
                weight = weight / (unit * unit);
            }
            errorWeight_[c][t] = weight;
            fitWeight_[c][t] = weight * slope * slope;
        }
        weighStart(c, low, high);
    }

    /// The slope in the dark says nothing of what it costs to be taken for a light: where a block holds both, lines start with the secant
    /// to its far end where that is steeper. Elsewhere it would only disturb, and so it does in refits: 0.1 dB.
    void weighStart(int c, F low, F high) {
        const F lowest = values_.metric(Values::lightOf(hn::Floor(low))), highest = values_.metric(Values::lightOf(hn::Floor(high)));
        const bool isLog = options_.hdrMetric == HdrMetric::Log;
        const M both = isLog ? highest - lowest > set(kOctave) : high - low > set(Values::kLargest / 4);
        for (int t = 0; t < kTexelCount; ++t) {
            const F toLow = (value_[c][t] - lowest) / hn::Max(target_[c][t] - low, set(kNear));
            const F toHigh = (highest - value_[c][t]) / hn::Max(high - target_[c][t], set(kNear));
            const F steepest = hn::Max(toLow, toHigh);
            const F raised = hn::Max(fitWeight_[c][t], errorWeight_[c][t] * steepest * steepest);
            startWeight_[c][t] = select(both, raised, fitWeight_[c][t]);
        }
    }

    /// Only ratios matter to a fit; the largest becomes 1 so that no product falls below what a float holds.
    void normalizeWeights() {
        F largest = set(1e-30f);
        for (int c = 0; c < 3; ++c)
            for (int t = 0; t < kTexelCount; ++t) largest = hn::Max(largest, fitWeight_[c][t]);
        weightScale_ = set(1.0f) / largest;
        for (int c = 0; c < 3; ++c)
            for (int t = 0; t < kTexelCount; ++t) {
                fitWeight_[c][t] = fitWeight_[c][t] * weightScale_;
                startWeight_[c][t] = startWeight_[c][t] * weightScale_;
            }
    }

    /// The space in which axes and partitions are judged: the metric's, channels scaled by the root of their weight, around the mean.
    void estimateSpace() {
        F total = zero(), mean[3] = {zero(), zero(), zero()};
        for (int t = 0; t < kTexelCount; ++t) {
            estimateWeight_[t] = significance_[t];
            if (options_.hdrMetric == HdrMetric::Relative) {
                const F unit =
                    (hn::Abs(light_[0][t]) + hn::Abs(light_[1][t]) + hn::Abs(light_[2][t])) * set(1.0f / 3) + set(options_.hdrScale);
                estimateWeight_[t] = significance_[t] / (unit * unit);
            }
            total = total + estimateWeight_[t];
            for (std::size_t c = 0; c < 3; ++c) {
                estimate_[c][t] = value_[c][t] * set(std::sqrt(options_.channelWeights[c]));
                mean[c] = mean[c] + estimateWeight_[t] * estimate_[c][t];
            }
        }
        const F share = set(1.0f) / total;
        for (int c = 0; c < 3; ++c)
            for (int t = 0; t < kTexelCount; ++t) estimate_[c][t] = estimate_[c][t] - mean[c] * share;
    }

    /// The space in which lines start: v, channels scaled by the root of their share of the weight.
    void axisSpace() {
        F total = set(1e-30f), share[3], mean[3];
        for (int c = 0; c < 3; ++c) share[c] = mean[c] = zero();
        for (int t = 0; t < kTexelCount; ++t) {
            axisWeight_[t] = startWeight_[0][t] + startWeight_[1][t] + startWeight_[2][t];
            total = total + axisWeight_[t];
            for (int c = 0; c < 3; ++c) {
                share[c] = share[c] + startWeight_[c][t];
                mean[c] = mean[c] + axisWeight_[t] * target_[c][t];
            }
        }
        for (int c = 0; c < 3; ++c) {
            const F scale = hn::Sqrt(share[c] / total);
            for (int t = 0; t < kTexelCount; ++t) axisSpace_[c][t] = (target_[c][t] - mean[c] / total) * scale;
        }
    }

    /// First positions, in [0, 1]: along the principal axis of each region, in the metric's own space.
    template <class Regions>
    void startPositions(const Regions& regions, Texels& position) const {
        for (int r = 0; r < Regions::kCount; ++r) {
            F total = set(1e-30f), mean[3] = {zero(), zero(), zero()};
            for (int t = 0; t < kTexelCount; ++t) {
                const F w = regions.inRegion(r, t, axisWeight_[t]);
                total = total + w;
                for (int c = 0; c < 3; ++c) mean[c] = mean[c] + w * axisSpace_[c][t];
            }
            const F share = set(1.0f) / total;
            for (int c = 0; c < 3; ++c) mean[c] = mean[c] * share;
            F m[6] = {zero(), zero(), zero(), zero(), zero(), zero()};  // xx xy xz yy yz zz
            for (int t = 0; t < kTexelCount; ++t) {
                const F w = regions.inRegion(r, t, axisWeight_[t]);
                const F x = axisSpace_[0][t] - mean[0], y = axisSpace_[1][t] - mean[1], z = axisSpace_[2][t] - mean[2];
                const F wx = w * x, wy = w * y;
                m[0] = m[0] + wx * x;
                m[1] = m[1] + wx * y;
                m[2] = m[2] + wx * z;
                m[3] = m[3] + wy * y;
                m[4] = m[4] + wy * z;
                m[5] = m[5] + w * z * z;
            }
            F axis[3];
            principalAxis<D>(m, 4, axis);
            F low = set(1e30f), high = set(-1e30f), along[kTexelCount];
            for (int t = 0; t < kTexelCount; ++t) {
                along[t] = (axisSpace_[0][t] - mean[0]) * axis[0] + (axisSpace_[1][t] - mean[1]) * axis[1] +
                           (axisSpace_[2][t] - mean[2]) * axis[2];
                const M counts = regions.inRegion(r, t, significance_[t]) > zero();
                low = select(counts, hn::Min(low, along[t]), low);
                high = select(counts, hn::Max(high, along[t]), high);
            }
            const F range = high - low;
            const F perRange = set(1.0f) / hn::Max(range, set(1e-20f));
            for (int t = 0; t < kTexelCount; ++t) {
                const F placed = clamp((along[t] - low) * perRange, zero(), set(1.0f));
                position[t] = r == 0 ? placed : regions.pick(t, position[t], placed);
            }
        }
    }

    /// Least-squares lines for texels at these positions, channel by channel because each has weights of its own.
    template <class Regions>
    void leastSquares(const Regions& regions, const Texels& position, const Texels* weight, Line* lines) const {
        for (int r = 0; r < Regions::kCount; ++r)
            for (int c = 0; c < 3; ++c) {
                // In terms of the mean and the deviation from it: no cancellation, and a constant falls out right.
                F total = set(1e-30f), meanK = zero(), meanT = zero();
                for (int t = 0; t < kTexelCount; ++t) {
                    const F w = regions.inRegion(r, t, weight[c][t]);
                    total = total + w;
                    meanK = meanK + w * position[t];
                    meanT = meanT + w * target_[c][t];
                }
                const F share = set(1.0f) / total;
                meanK = meanK * share;
                meanT = meanT * share;
                F kk = zero(), kt = zero();
                for (int t = 0; t < kTexelCount; ++t) {
                    const F w = regions.inRegion(r, t, weight[c][t]);
                    const F k = position[t] - meanK;
                    const F wk = w * k;
                    kk = kk + wk * k;
                    kt = kt + wk * (target_[c][t] - meanT);
                }
                const M distinct = kk > total * set(1e-12f);
                const F slope = hn::IfThenElseZero(distinct, kt / hn::Max(kk, set(1e-35f)));
                const F a = clamp(meanT - slope * meanK, set(Values::kSmallest), set(Values::kLargest));
                const F b = clamp(meanT + slope * (set(1.0f) - meanK), set(Values::kSmallest), set(Values::kLargest));
                lines[r].a[c] = a;
                lines[r].d[c] = b - a;
            }
    }

    /// Position of a texel along its line, unbounded: the nearest point in the weighted sense.
    HWY_INLINE F positionOn(const F (&a)[3], const F (&d)[3], int t) const {
        F along = zero(), length = set(1e-20f);
        for (int c = 0; c < 3; ++c) {
            const F wd = fitWeight_[c][t] * d[c];
            along = along + wd * (target_[c][t] - a[c]);
            length = length + wd * d[c];
        }
        return along / length;
    }

    template <class Regions>
    HWY_INLINE void lineAt(const Regions& regions, const Line* lines, int t, F (&a)[3], F (&d)[3]) const {
        for (int c = 0; c < 3; ++c) {
            a[c] = regions.pick(t, lines[0].a[c], lines[Regions::kCount - 1].a[c]);
            d[c] = regions.pick(t, lines[0].d[c], lines[Regions::kCount - 1].d[c]);
        }
    }

    static HWY_INLINE void turnWhere(M mask, Line& line) {
        for (int c = 0; c < 3; ++c) {
            line.a[c] = select(mask, line.a[c] + line.d[c], line.a[c]);
            line.d[c] = select(mask, zero() - line.d[c], line.d[c]);
        }
    }

    template <class Regions>
    void keepAnchorsLow(const Regions& regions, Texels& index) const {
        const F half = set((Regions::kSteps - 1) / 2);
        index[0] = hn::Min(index[0], half);
        if constexpr (Regions::kCount == 2)
            for (int i = 0; i < 3; ++i)
                index[Regions::kAnchors[i]] =
                    select(regions.anchorAt[i], hn::Min(index[Regions::kAnchors[i]], half), index[Regions::kAnchors[i]]);
    }

    /// What the format's interpolator makes of whole ends: floor((64 a + w d + 32) / 64), exact in a float.
    static HWY_INLINE F interpolate(F a, F d, F weight) {
        const F v = (a * set(64.0f) + d * weight + set(32.0f)) * set(1.0f / 64);
        return hn::Floor(v);
    }

    const Bc6hSearch& search_;
    const EncodeOptions& options_;
    Values values_;
    F light_[3][kTexelCount];        ///< as given
    F target_[3][kTexelCount];       ///< in v
    F value_[3][kTexelCount];        ///< in the metric
    F errorWeight_[3][kTexelCount];  ///< of a squared error in the metric
    F fitWeight_[3][kTexelCount];    ///< of a squared error in v
    F startWeight_[3][kTexelCount];  ///< the same while nothing is known of the line
    F refitWeight_[3][kTexelCount];
    F weightScale_;
    F significance_[kTexelCount];
    F estimate_[3][kTexelCount];
    F axisSpace_[3][kTexelCount];
    F axisWeight_[kTexelCount];
    F estimateWeight_[kTexelCount];
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
