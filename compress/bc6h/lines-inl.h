// BC6H: lines through the texels of each region, in v, and the error that they leave.
//
// A fit alternates two steps. Given the lines, each texel takes the index of the nearest point, in the weighted sense (chooseIndices).
// Given the indices, the lines are the solution of weighted least squares (refit). Errors in v are weighted by the slope of the metric at
// the texel at first. errorOf then computes the true error in the metric, and can replace these weights by a blend with the true cost of
// each miss, error / miss^2 (iteratively reweighted least squares).
#if defined(LIGHTCOOK_COMPRESS_BC6H_LINES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC6H_LINES_INL_H_
#undef LIGHTCOOK_COMPRESS_BC6H_LINES_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC6H_LINES_INL_H_
#endif

#include <hwy/highway.h>

#include <cstring>

#include "compress/bc6h/codes-inl.h"
#include "compress/bc6h/regions-inl.h"
#include "compress/bc6h/start-inl.h"
#include "compress/bc6h/subranges-inl.h"
#include "compress/bc6h/texels-inl.h"
#include "compress/bc6h/values-inl.h"
#include "compress/block/lanes-inl.h"
#include "compress/block/principal_axis-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D, bool kSigned>
class Bc6hLines : Lanes<D> {
    using typename Lanes<D>::F, typename Lanes<D>::M;
    using Lanes<D>::set, Lanes<D>::zero, Lanes<D>::clamp, Lanes<D>::select;
    using Values = Bc6hValues<D, kSigned>;

public:
    using Line = Bc6hLine<D>;
    using Texels = F[kTexelCount];

    Bc6hLines(const Bc6hSearch& search, const EncodeOptions& options) : texels_(search, options) {}

    /// Loads Lanes(d) blocks.
    void load(const Block* const* blocks) {
        texels_.load(blocks);
        start_.load(texels_);
    }
    const Bc6hTexels<D, kSigned>& texels() const { return texels_; }

    /// Makes start() fit to the raised weights of blocks of dim light beside black. Returns false if there is none: see Bc6hTexels.
    bool raiseStart() {
        if (!texels_.raiseStart()) return false;
        start_.load(texels_);
        return true;
    }
    void restoreStart() {
        texels_.restoreStart();
        start_.load(texels_);
    }

    /// Fits lines along the principal axes, and resets the weights of refits to the slopes of the metric.
    template <class Regions>
    void start(const Regions& regions, Line* lines) {
        Texels position;
        start_.positions(regions, position);
        leastSquares(regions, position, texels_.startWeight, lines);
        resetWeights();
    }
    /// Resets the weights of refits to the slopes of the metric.
    void resetWeights() { std::memcpy(refitWeight_, texels_.fitWeight, sizeof(refitWeight_)); }
    /// Moves the ends of the lines along them to the best of `count` starts, by the weights of refits: see Bc6hSubranges.
    template <class Regions>
    void chooseSubranges(const Regions& regions, const typename Bc6hCodes<D, kSigned>::ModeLanes& mode, int count, Line* lines) const {
        Bc6hSubranges<D, kSigned>(texels_, refitWeight_).chooseStart(regions, mode, count, lines);
    }
    /// Runs one step of the fit with unrounded lines: nearest indices, then least squares.
    template <class Regions>
    void refitFree(const Regions& regions, Texels& index, Line* lines) const {
        nearestIndices(regions, lines, index);
        refit(regions, index, lines);
    }

    /// Fits lines to texels with these indices.
    template <class Regions>
    void refit(const Regions& regions, const Texels& index, Line* lines) const {
        Texels position;
        for (int t = 0; t < kTexelCount; ++t) position[t] = regions.weightOfIndex(index[t]) * set(1.0f / 64);
        leastSquares(regions, position, refitWeight_, lines);
    }

    /// Swaps the ends of lines whose anchor texel lies beyond the middle: its index is stored without the highest bit.
    template <class Regions>
    void orient(const Regions& regions, Line* lines) const {
        swapWhere(positionOn(lines[0].a, lines[0].d, 0) > set(0.5f), lines[0]);
        if constexpr (Regions::kCount == 2) {
            F position = zero();
            for (int i = 0; i < 3; ++i)
                position = select(regions.anchorAt[i], positionOn(lines[1].a, lines[1].d, Regions::kAnchors[i]), position);
            swapWhere(position > set(0.5f), lines[1]);
        }
    }

    /// Sets the nearest index of each texel. Indices of anchors stay in the lower half.
    template <class Regions>
    void chooseIndices(const Regions& regions, const Line* lines, Texels& index) const {
        nearestIndices(regions, lines, index);
        keepAnchorsLow(regions, index);
    }

    /// Returns the error in the metric of lines with integer ends, with interpolation exactly as in a decoder.
    /// Reweigh: std::true_type updates the weights of refits by the cost of each miss
    template <class Regions, class Reweigh>
    F errorOf(const Regions& regions, const Line* lines, const Texels& index, Reweigh) {
        F error = zero();
        for (int t = 0; t < kTexelCount; ++t) {
            F a[3], d[3];
            lineAt<D>(regions, lines, t, a, d);
            const F share = regions.weightOfIndex(index[t]) * set(1.0f / 64);
            for (int c = 0; c < 3; ++c) {
                const F v = interpolate(a[c], d[c], share);
                const F miss = texels_.values().metric(Values::lightOf(v)) - texels_.value[c][t];
                const F squared = texels_.errorWeight[c][t] * miss * miss;
                error = error + squared;
                if constexpr (Reweigh::value) {
                    constexpr float kNear = Bc6hTexels<D, kSigned>::kNear;
                    const F away = v - texels_.target[c][t];
                    const F secant = squared * texels_.weightScale * roughInverse<D>(hn::Max(away * away, set(kNear * kNear)));
                    refitWeight_[c][t] = hn::MulAdd(texels_.fitWeight[c][t], set(0.3f), secant * set(0.7f));
                }
            }
        }
        return error;
    }

    /// The error of region r as a function of the ends of one channel, to second order in v with the weights of refits, where each texel
    /// takes its nearest index anew. The other channels add k^2 length - 2 k along to the error of a texel at position k.
    template <class Regions>
    class ChannelModel {
    public:
        ChannelModel(const Bc6hLines& of, const Regions& regions, int r, int c, const Line& line) : target_(of.texels_.target[c]) {
            for (int t = 0; t < kTexelCount; ++t) {
                along_[t] = zero();
                length_[t] = set(1e-20f);
                for (int other = 0; other < 3; ++other) {
                    const F w = regions.inRegion(r, t, of.refitWeight_[other][t]);
                    if (other == c) {
                        weight_[t] = w;
                        continue;
                    }
                    const F wd = w * line.d[other];
                    along_[t] = hn::MulAdd(wd, of.texels_.target[other][t] - line.a[other], along_[t]);
                    length_[t] = hn::MulAdd(wd, line.d[other], length_[t]);
                }
            }
        }
        /// Returns the error with these ends of the channel, less a constant.
        F errorOf(F a, F b) const {
            const F d = b - a, steps = set(Regions::kSteps), perStep = set(1.0f / Regions::kSteps), two = set(2.0f);
            F error = zero();
            for (int t = 0; t < kTexelCount; ++t) {
                const F x = target_[t] - a, wd = weight_[t] * d;
                const F along = hn::MulAdd(wd, x, along_[t]), length = hn::MulAdd(wd, d, length_[t]);
                const F k = hn::Round(clamp(along * roughInverse<D>(length) * steps, zero(), steps)) * perStep;
                error = hn::MulAdd(weight_[t] * x, x, hn::MulAdd(k, hn::MulSub(k, length, two * along), error));
            }
            return error;
        }

    private:
        const F* target_;
        F along_[kTexelCount], length_[kTexelCount], weight_[kTexelCount];
    };

private:
    /// Computes the least-squares line of each region for texels at these positions, channel by channel because each has its own weights.
    template <class Regions>
    void leastSquares(const Regions& regions, const Texels& position, const Texels* weight, Line* lines) const {
        for (int r = 0; r < Regions::kCount; ++r)
            for (int c = 0; c < 3; ++c) {
                // Work on deviations from the mean: no cancellation, and a constant block comes out exact.
                F total = set(1e-30f), meanK = zero(), meanT = zero();
                for (int t = 0; t < kTexelCount; ++t) {
                    const F w = regions.inRegion(r, t, weight[c][t]);
                    total = total + w;
                    meanK = hn::MulAdd(w, position[t], meanK);
                    meanT = hn::MulAdd(w, texels_.target[c][t], meanT);
                }
                const F perTotal = set(1.0f) / total;
                meanK = meanK * perTotal;
                meanT = meanT * perTotal;
                F kk = zero(), kt = zero();
                for (int t = 0; t < kTexelCount; ++t) {
                    const F w = regions.inRegion(r, t, weight[c][t]);
                    const F k = position[t] - meanK;
                    const F wk = w * k;
                    kk = hn::MulAdd(wk, k, kk);
                    kt = hn::MulAdd(wk, texels_.target[c][t] - meanT, kt);
                }
                const M distinct = kk > total * set(1e-12f);
                const F slope = hn::IfThenElseZero(distinct, kt / hn::Max(kk, set(1e-35f)));
                const F a = clamp(hn::NegMulAdd(slope, meanK, meanT), set(Values::kSmallest), set(Values::kLargest));
                const F b = clamp(hn::MulAdd(slope, set(1.0f) - meanK, meanT), set(Values::kSmallest), set(Values::kLargest));
                lines[r].a[c] = a;
                lines[r].d[c] = b - a;
            }
    }

    /// Returns the position of the point on a line that is nearest to a texel in the weighted sense; not clamped to [0, 1].
    HWY_INLINE F positionOn(const F (&a)[3], const F (&d)[3], int t) const {
        F along = zero(), length = set(1e-20f);
        for (int c = 0; c < 3; ++c) {
            const F wd = texels_.fitWeight[c][t] * d[c];
            along = hn::MulAdd(wd, texels_.target[c][t] - a[c], along);
            length = hn::MulAdd(wd, d[c], length);
        }
        return along * roughInverse<D>(length);
    }

    template <class Regions>
    HWY_INLINE void nearestIndices(const Regions& regions, const Line* lines, Texels& index) const {
        constexpr float kSteps = Regions::kSteps;
        for (int t = 0; t < kTexelCount; ++t) {
            F a[3], d[3];
            lineAt<D>(regions, lines, t, a, d);
            index[t] = hn::Round(clamp(positionOn(a, d, t) * set(kSteps), zero(), set(kSteps)));
        }
    }

    static HWY_INLINE void swapWhere(M mask, Line& line) {
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

    /// Interpolates integer ends as the format does: floor((64 a + 64 share d + 32) / 64), exact in a float.
    static HWY_INLINE F interpolate(F a, F d, F share) { return hn::Floor(hn::MulAdd(d, share, a + set(0.5f))); }

    Bc6hTexels<D, kSigned> texels_;
    Bc6hStart<D> start_;
    F refitWeight_[3][kTexelCount];  ///< weight of a squared error in v, in refits
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
