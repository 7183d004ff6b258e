// BC7: the regions of a block, lines through their texels, and the error of rounded lines. Values are in 0 .. 255.
//
// A fit alternates two steps: given the lines, each texel takes the nearest index (errorsOf); given the indices, the lines are the solution
// of weighted least squares (refit). First positions are projections onto the principal axis of each region.
#if defined(LIGHTCOOK_COMPRESS_BC7_FULL_LINES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC7_FULL_LINES_INL_H_
#undef LIGHTCOOK_COMPRESS_BC7_FULL_LINES_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC7_FULL_LINES_INL_H_
#endif

#include <hwy/highway.h>

#include <cmath>

#include "compress/block/block.h"
#include "compress/block/lanes-inl.h"
#include "compress/block/partitions.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// The channels after rotation. In modes 4 and 5 the last one is the separate channel.
template <class D>
struct Bc7View {
    const hn::Vec<D>* channel[4];
    float weight[4];
};

/// The line of a region, from a to b, by least squares for texels at positions k.
template <class D>
struct Bc7Line {
    hn::Vec<D> a[4], b[4];
    hn::Vec<D> n, k, kk;  ///< weighted sums of 1, k and k^2

    /// Returns the same line with its ends moved: the texels at 0 and 1 come to positions `from` and `from + range`.
    template <int kChannels>
    [[nodiscard]] Bc7Line moved(float from, float range) const {
        Bc7Line line;
        for (int c = 0; c < kChannels; ++c) {
            const auto along = (b[c] - a[c]) * hn::Set(D(), 1 / range);
            line.a[c] = hn::NegMulAdd(along, hn::Set(D(), from), a[c]);
            line.b[c] = line.a[c] + along;
        }
        const auto f = hn::Set(D(), from), r = hn::Set(D(), range);
        line.n = n;
        line.k = hn::MulAdd(f, n, r * k);
        line.kk = hn::MulAdd(f, line.k, r * hn::MulAdd(f, k, r * kk));
        return line;
    }
};

/// The partition of each lane.
template <class D>
struct Bc7Regions {
    using F = hn::Vec<D>;
    using DI = hn::RebindToSigned<D>;
    using I = hn::Vec<DI>;
    hn::Mask<D> second[kTexelCount], third[kTexelCount];  ///< lanes where the texel is in region 1, in region 2

    template <int kRegions>
    static Bc7Regions of(I partition) {
        const D d;
        const DI di;
        HWY_ALIGN std::int32_t number[hn::MaxLanes(D())], second[hn::MaxLanes(D())], third[hn::MaxLanes(D())];
        hn::Store(partition, di, number);
        for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) {
            const auto p = static_cast<std::size_t>(number[lane]);
            second[lane] = kRegions == 2 ? kTwoRegions[p] : kThreeRegionsMask[0][p];
            third[lane] = kRegions == 2 ? 0 : kThreeRegionsMask[1][p];
        }
        const I seconds = hn::Load(di, second), thirds = hn::Load(di, third);
        Bc7Regions regions;
        for (int t = 0; t < kTexelCount; ++t) {
            regions.second[t] = hn::RebindMask(d, hn::TestBit(seconds, hn::Set(di, 1 << t)));
            regions.third[t] = hn::RebindMask(d, hn::TestBit(thirds, hn::Set(di, 1 << t)));
        }
        return regions;
    }
    /// Returns the weight of a texel in region r, zero if it is in another one.
    template <int kRegions>
    HWY_INLINE F inRegion(int r, int t, F weight) const {
        if constexpr (kRegions == 1) return weight;
        if constexpr (kRegions == 2) return r ? hn::IfThenElseZero(second[t], weight) : hn::IfThenZeroElse(second[t], weight);
        if (r == 1) return hn::IfThenElseZero(second[t], weight);
        if (r == 2) return hn::IfThenElseZero(third[t], weight);
        return hn::IfThenZeroElse(second[t], hn::IfThenZeroElse(third[t], weight));
    }
    /// Selects the value of the region that holds a texel.
    template <int kRegions>
    HWY_INLINE F pick(int t, F ofFirst, F ofSecond, F ofThird) const {
        if constexpr (kRegions == 1) return ofFirst;
        const F two = hn::IfThenElse(second[t], ofSecond, ofFirst);
        if constexpr (kRegions == 2) return two;
        return hn::IfThenElse(third[t], ofThird, two);
    }
};

template <class D>
class Bc7Lines : Lanes<D> {
    using typename Lanes<D>::F, typename Lanes<D>::M;
    using Lanes<D>::set, Lanes<D>::zero, Lanes<D>::clamp, Lanes<D>::select;
    using View = Bc7View<D>;
    using Regions = Bc7Regions<D>;

public:
    using Line = Bc7Line<D>;
    using Texels = F[kTexelCount];

    Texels significance;  ///< set this before any call

    /// Sets the position of each texel on the principal axis of its region: 0 and 1 are the outermost significant texels.
    template <int kRegions, int kChannels>
    void startPositions(const Regions& regions, const View& view, Texels& position) const {
        for (int r = 0; r < kRegions; ++r) {
            F total = set(1e-30f), mean[kChannels];
            for (F& m : mean) m = zero();
            for (int t = 0; t < kTexelCount; ++t) {
                const F w = regions.template inRegion<kRegions>(r, t, significance[t]);
                total = total + w;
                for (int c = 0; c < kChannels; ++c) mean[c] = mean[c] + w * view.channel[c][t];
            }
            const F perTotal = set(1.0f) / total;
            for (F& m : mean) m = m * perTotal;
            F axis[kChannels];
            principalAxis<kRegions, kChannels>(regions, r, view, mean, axis);
            F low = set(1e30f), high = set(-1e30f), along[kTexelCount];
            for (int t = 0; t < kTexelCount; ++t) {
                along[t] = zero();
                for (int c = 0; c < kChannels; ++c) along[t] = along[t] + (view.channel[c][t] - mean[c]) * axis[c];
                const M counts = regions.template inRegion<kRegions>(r, t, significance[t]) > zero();
                low = select(counts, hn::Min(low, along[t]), low);
                high = select(counts, hn::Max(high, along[t]), high);
            }
            const F perRange = set(1.0f) / hn::Max(high - low, set(1e-20f));
            for (int t = 0; t < kTexelCount; ++t) {
                const F placed = clamp((along[t] - low) * perRange, zero(), set(1.0f));
                position[t] = r == 0 ? placed : regions.template pick<kRegions>(t, position[t], r == 1 ? placed : position[t], placed);
            }
        }
    }

    /// Computes the weighted least-squares line of each region for texels at these positions.
    template <int kRegions, int kChannels>
    void leastSquares(const Regions& regions, const View& view, const Texels& position, Line* lines) const {
        for (int r = 0; r < kRegions; ++r) {
            F total = set(1e-30f), meanK = zero(), mean[kChannels];
            for (F& m : mean) m = zero();
            for (int t = 0; t < kTexelCount; ++t) {
                const F w = regions.template inRegion<kRegions>(r, t, significance[t]);
                total = total + w;
                meanK = meanK + w * position[t];
                for (int c = 0; c < kChannels; ++c) mean[c] = mean[c] + w * view.channel[c][t];
            }
            const F perTotal = set(1.0f) / total;
            meanK = meanK * perTotal;
            for (F& m : mean) m = m * perTotal;
            F kk = zero(), kt[kChannels];
            for (F& v : kt) v = zero();
            for (int t = 0; t < kTexelCount; ++t) {
                const F k = position[t] - meanK;
                const F wk = regions.template inRegion<kRegions>(r, t, significance[t]) * k;
                kk = kk + wk * k;
                for (int c = 0; c < kChannels; ++c) kt[c] = kt[c] + wk * (view.channel[c][t] - mean[c]);
            }
            const M distinct = kk > total * set(1e-10f);
            const F perKk = hn::IfThenElseZero(distinct, set(1.0f) / hn::Max(kk, set(1e-35f)));
            for (int c = 0; c < kChannels; ++c) {
                const F slope = kt[c] * perKk;
                lines[r].a[c] = mean[c] - slope * meanK;
                lines[r].b[c] = lines[r].a[c] + slope;
            }
            lines[r].n = total;
            lines[r].k = total * meanK;
            lines[r].kk = hn::MulAdd(lines[r].k, meanK, kk);
        }
    }

    /// Returns the interpolation weight of an index, in 64ths: 64 i / steps, rounded, as in the format's tables.
    static HWY_INLINE F weightOfIndex(F index, float steps) { return hn::Round(index * set(64.0f / steps)); }

    /// Computes the error of each region for lines with integer ends and the nearest of steps + 1 indices, with interpolation exactly as in
    /// a decoder.
    /// index  receives the indices. May be null
    template <int kRegions, int kChannels>
    HWY_INLINE void errorsOf(const Regions& regions, const View& view, const Line* lines, float steps, F* error, Texels* index) const {
        bool alike = true;
        for (int c = 0; c < kChannels; ++c) alike &= view.weight[c] == 1;
        if (alike)
            errorsWith<kRegions, kChannels, true>(regions, view, lines, steps, error, index);
        else
            errorsWith<kRegions, kChannels, false>(regions, view, lines, steps, error, index);
    }

    /// Fits lines to texels with these indices.
    template <int kRegions, int kChannels>
    void refit(const Regions& regions, const View& view, float steps, const Texels& index, Line* lines) const {
        Texels position;
        for (int t = 0; t < kTexelCount; ++t) position[t] = weightOfIndex(index[t], steps) * set(1.0f / 64);
        leastSquares<kRegions, kChannels>(regions, view, position, lines);
    }

private:
    /// kAlike  all channels weigh 1
    template <int kRegions, int kChannels, bool kAlike>
    HWY_INLINE void errorsWith(const Regions& regions, const View& view, const Line* lines, float steps, F* error, Texels* index) const {
        const auto weighted = [&](F value, int c) { return kAlike ? value : value * set(view.weight[c]); };
        F along[kRegions][kChannels], half[kRegions][kChannels], scale[kRegions];
        for (int r = 0; r < kRegions; ++r) {
            F length = set(1e-20f);
            for (int c = 0; c < kChannels; ++c) {
                along[r][c] = lines[r].b[c] - lines[r].a[c];
                half[r][c] = lines[r].a[c] + set(0.5f);
                length = hn::MulAdd(weighted(along[r][c], c), along[r][c], length);
            }
            scale[r] = set(steps) / length;
        }
        constexpr int kSecond = kRegions > 1 ? 1 : 0, kThird = kRegions > 2 ? 2 : 0;
        const auto pick = [&](int t, const F(&of)[kRegions][kChannels], int c) {
            return regions.template pick<kRegions>(t, of[0][c], of[kSecond][c], of[kThird][c]);
        };
        F sums[3] = {zero(), zero(), zero()};
        for (int t = 0; t < kTexelCount; ++t) {
            F d[kChannels], a[kChannels], position = zero();
            for (int c = 0; c < kChannels; ++c) {
                d[c] = pick(t, along, c);
                a[c] = pick(t, half, c);
                position = hn::MulAdd(view.channel[c][t] - (a[c] - set(0.5f)), weighted(d[c], c), position);
            }
            position = position * regions.template pick<kRegions>(t, scale[0], scale[kSecond], scale[kThird]);
            const F nearest = hn::Round(clamp(position, zero(), set(steps)));
            if (index) (*index)[t] = nearest;
            const F weight = weightOfIndex(nearest, steps) * set(1.0f / 64);
            F sum = zero();
            for (int c = 0; c < kChannels; ++c) {
                // Exact: multiples of 1/64 below 2^8.
                const F miss = hn::Floor(hn::MulAdd(d[c], weight, a[c])) - view.channel[c][t];
                sum = hn::MulAdd(weighted(miss, c), miss, sum);
            }
            sum = sum * significance[t];
            for (int r = 0; r < kRegions; ++r) sums[r] = sums[r] + regions.template inRegion<kRegions>(r, t, sum);
        }
        for (int r = 0; r < kRegions; ++r) error[r] = sums[r];
    }

    /// Finds the principal axis in the space of channels scaled by the root of their weight, by power iteration on the covariance matrix,
    /// starting with its row of the largest diagonal element.
    template <int kRegions, int kChannels>
    void principalAxis(const Regions& regions, int r, const View& view, const F (&mean)[kChannels], F (&axis)[kChannels]) const {
        if constexpr (kChannels == 1) {
            axis[0] = set(1.0f);
            return;
        }
        F m[kChannels][kChannels];
        for (auto& row : m)
            for (F& v : row) v = zero();
        for (int t = 0; t < kTexelCount; ++t) {
            const F w = regions.template inRegion<kRegions>(r, t, significance[t]);
            F away[kChannels];
            for (int c = 0; c < kChannels; ++c) away[c] = (view.channel[c][t] - mean[c]) * set(std::sqrt(view.weight[c]));
            for (int i = 0; i < kChannels; ++i)
                for (int j = i; j < kChannels; ++j) m[i][j] = m[i][j] + w * away[i] * away[j];
        }
        for (int i = 0; i < kChannels; ++i)
            for (int j = 0; j < i; ++j) m[i][j] = m[j][i];
        F largest = m[0][0];
        for (int c = 0; c < kChannels; ++c) axis[c] = m[0][c];
        for (int i = 1; i < kChannels; ++i) {
            const M longer = m[i][i] > largest;
            largest = hn::Max(largest, m[i][i]);
            for (int c = 0; c < kChannels; ++c) axis[c] = select(longer, m[i][c], axis[c]);
        }
        for (int iteration = 0; iteration < 4; ++iteration) {
            F norm = set(1e-30f), next[kChannels];
            for (const F& a : axis) norm = hn::Max(norm, hn::Abs(a));
            const F scale = set(1.0f) / norm;
            for (F& a : axis) a = a * scale;
            for (int i = 0; i < kChannels; ++i) {
                next[i] = zero();
                for (int j = 0; j < kChannels; ++j) next[i] = next[i] + m[i][j] * axis[j];
            }
            for (int i = 0; i < kChannels; ++i) axis[i] = next[i];
        }
        // Scale once more, so that a projection onto the axis weights the channels.
        for (int c = 0; c < kChannels; ++c) axis[c] = axis[c] * set(std::sqrt(view.weight[c]));
    }
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
