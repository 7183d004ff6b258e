// BC7, closed forms: fits one to three regions, one block in each lane. Positions are projections onto the principal axis of a region;
// indices are rounded positions; ends are solved and rounded in closed form (closed_form/least_squares-inl.h).
#if defined(LIGHTCOOK_COMPRESS_BC7_CLOSED_FORM_REGION_FIT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC7_CLOSED_FORM_REGION_FIT_INL_H_
#undef LIGHTCOOK_COMPRESS_BC7_CLOSED_FORM_REGION_FIT_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC7_CLOSED_FORM_REGION_FIT_INL_H_
#endif

#include <hwy/highway.h>

#include <cstddef>

#include "compress/bc7/closed_form/least_squares-inl.h"
#include "compress/bc7/closed_form/texels-inl.h"
#include "compress/bc7/fast/block-inl.h"
#include "compress/bc7/modes.h"
#include "compress/block/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// The regions of each lane's block, their moments and their error on ideal lines.
template <class D, int kRegions, int kChannels>
class Bc7RegionFit : Lanes<D> {
    using typename Lanes<D>::F, typename Lanes<D>::M, typename Lanes<D>::DI, typename Lanes<D>::I;
    using Lanes<D>::set, Lanes<D>::zero, Lanes<D>::clamp, Lanes<D>::select;
    using Texels = Bc7ScaledTexels<D>;
    using Lines = Bc7LeastSquares<D>;
    using Moments = Bc7Moments<D, kChannels>;
    using Sums = Bc7PositionSums<D, kChannels>;
    static constexpr int kProducts = productsOf(kChannels);

public:
    using Ends = Bc7RoundedEnds<D>;

    /// channel  numbers of the channels to fit
    /// choice   partition, see Bc7PartitionRanking; ignored for one region
    /// third    the texels of region 2 of 3, as bits 0 to 15
    Bc7RegionFit(const Texels& texels, const std::size_t (&channel)[kChannels], I choice, I third = hn::Zero(DI()))
        : texels_(texels), choice_(choice), third_(third) {
        for (int c = 0; c < kChannels; ++c) channel_[c] = channel[c];
    }

    /// Computes the moments of all regions from those of the block, and the positions of the texels on their principal axes.
    void start(const F (&blockProduct)[kProducts], int iterations) {
        momentsOf(blockProduct);
        for (int r = 0; r < kRegions; ++r) {
            F covariance[kProducts];
            trace_[r] = Lines::template centered<kChannels>(moments_[r], covariance);
            value_[r] = Lines::template axisOf<kChannels>(covariance, iterations, axis_[r]);
        }
        for (int t = 0; t < kTexelCount; ++t) {
            const auto axis = [&](int c) { return pick(t, [&](int r) { return axis_[r][c]; }); };
            F p = x(0, t) * axis(0);
            for (int c = 1; c < kChannels; ++c) p = hn::MulAdd(x(c, t), axis(c), p);
            position_[t] = p;
        }
        F low[kRegions], high[kRegions];
        for (int r = 0; r < kRegions; ++r) low[r] = set(1e30f), high[r] = set(-1e30f);
        for (int t = 0; t < kTexelCount; ++t)
            for (int r = 0; r < kRegions; ++r) {
                low[r] = hn::Min(low[r], inRegion(r, t, position_[t], set(1e30f)));
                high[r] = hn::Max(high[r], inRegion(r, t, position_[t], set(-1e30f)));
            }
        for (int r = 0; r < kRegions; ++r) {
            low_[r] = low[r];
            perRange_[r] = set(1.0f) / hn::Max(high[r] - low[r], set(1e-6f));
        }
    }
    const F& position(int t) const { return position_[t]; }
    const F* axis(int region) const { return axis_[region]; }
    F trace(int region) const { return trace_[region]; }
    F largestEigenvalue(int region) const { return value_[region]; }

    /// Fits a mode to the indices nearest to the positions on the axes, then `refits` times to those nearest to the rounded ends.
    /// Returns the error.
    F fit(int mode, int bits, int indexBits, int refits, Ends (&ends)[kRegions]) const {
        const Bc7Mode& m = kBc7Modes[static_cast<std::size_t>(mode)];
        const auto lowBits = m.endpointLowBits ? Lines::LowBits::PerEnd
                             : m.sharedLowBits ? Lines::LowBits::PerRegion
                                               : Lines::LowBits::None;
        const auto steps = static_cast<float>((1 << indexBits) - 1);
        Sums sums[kRegions];
        F scale[kRegions], offset[kRegions];
        for (int r = 0; r < kRegions; ++r) {
            scale[r] = perRange_[r] * set(steps);
            offset[r] = zero() - low_[r] * scale[r];
        }
        addUp(steps, sums, [&](int t) {
            return hn::MulAdd(position_[t], pick(t, [&](int r) { return scale[r]; }), pick(t, [&](int r) { return offset[r]; }));
        });
        F error = endsOf(sums, bits, lowBits, ends);
        for (int i = 0; i < refits; ++i) {
            F d[kRegions][kChannels];
            for (int r = 0; r < kRegions; ++r) {
                F square = set(1e-12f);
                for (int c = 0; c < kChannels; ++c) {
                    d[r][c] = ends[r].value[1][c] - ends[r].value[0][c];
                    square = hn::MulAdd(d[r][c], d[r][c], square);
                }
                const F perSquare = set(steps) / square;
                offset[r] = zero();
                for (int c = 0; c < kChannels; ++c) {
                    d[r][c] = d[r][c] * perSquare;
                    offset[r] = hn::MulAdd(texels_.mean[channel_[c]] - ends[r].value[0][c], d[r][c], offset[r]);
                }
            }
            addUp(steps, sums, [&](int t) {
                F p = pick(t, [&](int r) { return offset[r]; });
                for (int c = 0; c < kChannels; ++c) p = hn::MulAdd(x(c, t), pick(t, [&](int r) { return d[r][c]; }), p);
                return p;
            });
            Ends fresh[kRegions];
            const F freshError = endsOf(sums, bits, lowBits, fresh);
            const M better = freshError < error;
            if (hn::AllFalse(D(), better)) break;
            error = hn::Min(error, freshError);
            for (int r = 0; r < kRegions; ++r)
                for (int e = 0; e < 2; ++e) {
                    ends[r].low[e] = select(better, fresh[r].low[e], ends[r].low[e]);
                    for (int c = 0; c < kChannels; ++c) {
                        ends[r].code[e][c] = select(better, fresh[r].code[e][c], ends[r].code[e][c]);
                        ends[r].value[e][c] = select(better, fresh[r].value[e][c], ends[r].value[e][c]);
                    }
                }
        }
        return error;
    }

    /// Tries all low bits of the ends of one region, with the interpolated values rounded as in a decoder, and keeps the best.
    /// where  lanes that may change
    /// error  receives the least error found, less the expected error of rounding, so that it compares with that of fit()
    void roundExactly(int bits, int indexBits, M where, Ends& ends, F& error) const {
        static_assert(kRegions == 1 && kChannels == 4);
        const auto steps = static_cast<float>((1 << indexBits) - 1);
        F least = set(1e30f);
        Ends trial, best = ends;
        for (int low = 0; low < 4; ++low) {
            F offset = zero(), d[kChannels], square = set(1e-12f);
            for (int c = 0; c < kChannels; ++c) {
                for (int e = 0; e < 2; ++e)
                    Lines::round(ends.ideal[e][c], bits, (low >> e) & 1, texels_, channel_[c], trial.code[e][c], trial.value[e][c]);
                d[c] = trial.value[1][c] - trial.value[0][c];
                square = hn::MulAdd(d[c], d[c], square);
            }
            const F perSquare = set(steps) / square;
            F a64[kChannels], d64[kChannels];  // interpolated values in 64ths of a code
            for (int c = 0; c < kChannels; ++c) {
                const F perScale = set(texels_.perScale[channel_[c]]);
                a64[c] = hn::MulAdd(trial.value[0][c], perScale * set(64.0f), set(32.0f));
                d64[c] = d[c] * perScale;
                d[c] = d[c] * perSquare;
                offset = hn::MulAdd(texels_.mean[channel_[c]] - trial.value[0][c], d[c], offset);
            }
            F sum = zero();
            for (int t = 0; t < kTexelCount; ++t) {
                F p = offset, square4 = zero();
                for (int c = 0; c < kChannels; ++c) p = hn::MulAdd(x(c, t), d[c], p);
                const F k = hn::Round(hn::Round(clamp(p, zero(), set(steps))) * set(64.0f / steps));
                for (int c = 0; c < kChannels; ++c) {
                    const F value = hn::Floor(hn::MulAdd(d64[c], k, a64[c]) * set(1.0f / 64)) * set(texels_.scale[channel_[c]]);
                    const F miss = value - texels_.mean[channel_[c]] - x(c, t);
                    square4 = hn::MulAdd(miss, miss, square4);
                }
                sum = hn::MulAdd(texels_.weight[t], square4, sum);
            }
            const M better = hn::And(where, sum < least);
            least = select(better, sum, least);
            for (int e = 0; e < 2; ++e) {
                best.low[e] = select(better, set(static_cast<float>((low >> e) & 1)), best.low[e]);
                for (int c = 0; c < kChannels; ++c) {
                    best.code[e][c] = select(better, trial.code[e][c], best.code[e][c]);
                    best.value[e][c] = select(better, trial.value[e][c], best.value[e][c]);
                }
            }
        }
        ends = best;
        // Expected squared error of rounding, for four channels most of whose values are interpolated: 1/12 each for values that are.
        constexpr float kRounding = 4.0f / 15;
        error = select(where, hn::Max(hn::NegMulAdd(texels_.total, set(kRounding), least), zero()), error);
    }

private:
    HWY_INLINE const F& x(int channel, int t) const { return texels_.x[channel_[channel]][t]; }
    HWY_INLINE M second(int t) const {
        return hn::RebindMask(D(), hn::TestBit(choice_, hn::Set(DI(), static_cast<std::int32_t>(0x10000u << t))));
    }
    HWY_INLINE M third(int t) const { return hn::RebindMask(D(), hn::TestBit(third_, hn::Set(DI(), 1 << t))); }
    HWY_INLINE M isIn(int region, int t) const { return region == 1 ? second(t) : third(t); }
    /// Selects the value of the region that holds a texel.
    template <class Of>
    HWY_INLINE F pick(int t, const Of& of) const {
        F value = of(0);
        for (int r = 1; r < kRegions; ++r) value = select(isIn(r, t), of(r), value);
        return value;
    }
    HWY_INLINE F inRegion(int region, int t, F value, F elsewhere) const {
        if (region > 0) return select(isIn(region, t), value, elsewhere);
        for (int r = 1; r < kRegions; ++r) value = select(isIn(r, t), elsewhere, value);
        return value;
    }

    void momentsOf(const F (&blockProduct)[kProducts]) {
        Moments& first = moments_[0];
        first.n = texels_.total;
        for (F& v : first.sum) v = zero();
        for (int i = 0; i < kProducts; ++i) first.product[i] = blockProduct[i];
        for (int r = 1; r < kRegions; ++r) {
            Moments& other = moments_[r];
            other.n = zero();
            for (F& v : other.sum) v = zero();
            for (F& v : other.product) v = zero();
            for (int t = 0; t < kTexelCount; ++t) {
                const F w = hn::IfThenElseZero(isIn(r, t), texels_.weight[t]);
                other.n = other.n + w;
                for (int i = 0, at = 0; i < kChannels; ++i) {
                    const F wx = w * x(i, t);
                    other.sum[i] = other.sum[i] + wx;
                    for (int j = i; j < kChannels; ++j, ++at) other.product[at] = hn::MulAdd(wx, x(j, t), other.product[at]);
                }
            }
            first.n = first.n - other.n;
            for (int c = 0; c < kChannels; ++c) first.sum[c] = first.sum[c] - other.sum[c];
            for (int i = 0; i < kProducts; ++i) first.product[i] = first.product[i] - other.product[i];
        }
        // A region without weight has no mean: its moments are the rounding of a difference, of either sign.
        constexpr float kRoundingOfSums = 4e-6f;
        const M hasWeight = first.n > texels_.total * set(kRoundingOfSums);
        first.n = hn::IfThenElseZero(hasWeight, first.n);
        for (F& v : first.sum) v = hn::IfThenElseZero(hasWeight, v);
        for (F& v : first.product) v = hn::IfThenElseZero(hasWeight, v);
    }
    /// Rounds positions to indices and adds up the sums for the interpolation weights of the format.
    template <class Position>
    HWY_INLINE void addUp(float steps, Sums (&sums)[kRegions], const Position& position) const {
        for (Sums& s : sums) {
            s.k = s.kk = zero();
            for (F& v : s.kx) v = zero();
        }
        for (int t = 0; t < kTexelCount; ++t) {
            const F index = hn::Round(clamp(position(t), zero(), set(steps)));
            const F k = hn::Round(index * set(64.0f / steps)) * set(1.0f / 64);
            const F wk = texels_.weight[t] * k;
            add(t, wk, k, sums[0]);
            for (int r = 1; r < kRegions; ++r) add(t, hn::IfThenElseZero(isIn(r, t), wk), k, sums[r]);
        }
        for (int r = 1; r < kRegions; ++r) {
            sums[0].k = sums[0].k - sums[r].k;
            sums[0].kk = sums[0].kk - sums[r].kk;
            for (int c = 0; c < kChannels; ++c) sums[0].kx[c] = sums[0].kx[c] - sums[r].kx[c];
        }
    }
    HWY_INLINE void add(int t, F wk, F k, Sums& s) const {
        s.k = s.k + wk;
        s.kk = hn::MulAdd(wk, k, s.kk);
        for (int c = 0; c < kChannels; ++c) s.kx[c] = hn::MulAdd(wk, x(c, t), s.kx[c]);
    }
    F endsOf(const Sums (&sums)[kRegions], int bits, typename Lines::LowBits lowBits, Ends (&ends)[kRegions]) const {
        F error = zero();
        for (int r = 0; r < kRegions; ++r)
            error = error + Lines::template endsOf<kChannels>(texels_, moments_[r].n, moments_[r].sum, trace_[r], sums[r], channel_, bits,
                                                              lowBits, ends[r]);
        return error;
    }

    const Texels& texels_;
    std::size_t channel_[kChannels];
    I choice_, third_;
    Moments moments_[kRegions];
    F trace_[kRegions], value_[kRegions], axis_[kRegions][kChannels];
    F position_[kTexelCount], low_[kRegions], perRange_[kRegions];
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
