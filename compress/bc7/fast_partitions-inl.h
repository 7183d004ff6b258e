// BC7, fast kernel: predicts the best partitions into two regions from moments in the plane of the two principal axes.
//
// The error of the best line of a region is the smaller eigenvalue of its covariance matrix, which is a closed form for a 2 x 2 matrix. The
// variance outside the plane is left out, since it differs little between partitions. Quantization adds a fixed share of the larger
// eigenvalue. The sums of region 1 are those of its parts of the four rows of texels, which are computed once
// for each of the 16 subsets of a row.
#if defined(LIGHTCOOK_COMPRESS_BC7_FAST_PARTITIONS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC7_FAST_PARTITIONS_INL_H_
#undef LIGHTCOOK_COMPRESS_BC7_FAST_PARTITIONS_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC7_FAST_PARTITIONS_INL_H_
#endif

#include <hwy/highway.h>

#include <array>
#include <bit>
#include <cstddef>

#include "compress/bc7/fast_lines-inl.h"
#include "compress/bc7/fast_texels-inl.h"
#include "compress/block/lanes-inl.h"
#include "compress/block/partitions.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D>
class Bc7FastPartitions : Lanes<D> {
    using typename Lanes<D>::F, typename Lanes<D>::M, typename Lanes<D>::DI, typename Lanes<D>::I;
    using Lanes<D>::set, Lanes<D>::zero, Lanes<D>::select;

public:
    static constexpr int kMostKept = 4;
    F score[kMostKept];   ///< predicted errors, best first, without the variance outside the plane
    I choice[kMostKept];  ///< number of the partition in the low 6 bits, the texels of region 1 in the high 16

    /// Ranks the first `count` partitions and keeps the best ones.
    /// p, q          positions of the texels on the principal axes, about their mean
    /// quantization  share of the variance along a line that quantization adds
    void rank(const Bc7FastTexels<D>& texels, const F (&p)[kTexelCount], const F (&q)[kTexelCount], int count, int keep,
              float quantization) {
        for (int i = 0; i < keep; ++i) {
            score[i] = set(1e30f);
            choice[i] = hn::Zero(DI());
        }
        if (texels.uniform)
            rankWith<true>(texels, p, q, count, keep, quantization);
        else
            rankWith<false>(texels, p, q, count, keep, quantization);
    }

private:
    static constexpr int kSums = 5;  ///< p, q, pp, pq, qq
    static constexpr std::array<float, kTexelCount> kInverse = [] {
        std::array<float, kTexelCount> inverse{};
        for (std::size_t n = 1; n < inverse.size(); ++n) inverse[n] = 1 / static_cast<float>(n);
        return inverse;
    }();

    template <bool kUniform>
    void rankWith(const Bc7FastTexels<D>& texels, const F (&p)[kTexelCount], const F (&q)[kTexelCount], int count, int keep,
                  float quantization) {
        constexpr int kAll = kUniform ? kSums : kSums + 1;
        F part[4][16][kAll];
        for (std::size_t y = 0; y < 4; ++y)
            for (std::size_t subset = 0; subset < 16; ++subset) {
                F* to = part[y][subset];
                if (subset == 0) {
                    for (int i = 0; i < kAll; ++i) to[i] = zero();
                } else if (std::has_single_bit(subset)) {
                    const std::size_t t = 4 * y + static_cast<std::size_t>(std::countr_zero(subset));
                    const F w = texels.weight[t], wp = w * p[t], wq = w * q[t];
                    to[0] = wp;
                    to[1] = wq;
                    to[2] = wp * p[t];
                    to[3] = wp * q[t];
                    to[4] = wq * q[t];
                    if constexpr (!kUniform) to[5] = w;
                } else {
                    const F *one = part[y][subset & (subset - 1)], *other = part[y][subset & (~subset + 1)];
                    for (int i = 0; i < kAll; ++i) to[i] = one[i] + other[i];
                }
            }
        F all[kAll];
        for (int i = 0; i < kAll; ++i) all[i] = part[0][15][i] + part[1][15][i] + (part[2][15][i] + part[3][15][i]);
        const F traceShare = set(0.5f + 0.5f * quantization), rootShare = set(0.5f - 0.5f * quantization);
        for (int number = 0; number < count; ++number) {
            const std::uint32_t mask = kTwoRegions[static_cast<std::size_t>(number)];
            const F *r0 = part[0][mask & 15], *r1 = part[1][(mask >> 4) & 15], *r2 = part[2][(mask >> 8) & 15], *r3 = part[3][mask >> 12];
            F second[kAll], first[kAll];
            for (int i = 0; i < kAll; ++i) {
                second[i] = r0[i] + r1[i] + (r2[i] + r3[i]);
                first[i] = all[i] - second[i];
            }
            const auto n = static_cast<std::size_t>(std::popcount(mask));
            const F perSecond = kUniform ? set(kInverse[n]) : Bc7FastLines<D>::inverse(second[kAll - 1]);
            const F perFirst = kUniform ? set(kInverse[kTexelCount - n]) : Bc7FastLines<D>::inverse(first[kAll - 1]);
            F trace = zero(), root = zero();
            addRegion(first, perFirst, trace, root);
            addRegion(second, perSecond, trace, root);
            insert(hn::NegMulAdd(root, rootShare, trace * traceShare), number, mask, keep);
        }
    }
    /// Adds the sum and the difference of the eigenvalues of a region.
    static HWY_INLINE void addRegion(const F* s, F perN, F& trace, F& root) {
        const F p = s[0] * perN, q = s[1] * perN;
        const F pp = hn::NegMulAdd(p, s[0], s[2]), pq = hn::NegMulAdd(p, s[1], s[3]), qq = hn::NegMulAdd(q, s[1], s[4]);
        const F difference = pp - qq, twice = pq + pq;
        trace = trace + (pp + qq);
        root = root + roughRoot(hn::MulAdd(difference, difference, twice * twice));
    }
    /// Returns the root of x to 0.07 %: a linear function of the bits approximates its inverse, and a Newton step has constants for the
    /// least error (Kadlec 2010, Improving the fast inverse square root). It is the same on every processor, and faster than an exact root.
    static HWY_INLINE F roughRoot(F x) {
        const F guess = hn::BitCast(D(), hn::Set(DI(), 0x5F1FFFF9) - hn::ShiftRight<1>(hn::BitCast(DI(), x)));
        return x * guess * hn::NegMulAdd(x * guess, guess * set(0.703952253f), set(0.703952253f * 2.38924456f));
    }
    HWY_INLINE void insert(F error, int number, std::uint32_t mask, int keep) {
        I candidate = hn::Set(DI(), static_cast<std::int32_t>(mask << 16 | static_cast<std::uint32_t>(number)));
        for (int i = 0; i < keep; ++i) {  // the displaced entry moves on
            const M better = error < score[i];
            const auto betterI = hn::RebindMask(DI(), better);
            const F lost = select(better, score[i], error);
            const I lostCandidate = hn::IfThenElse(betterI, choice[i], candidate);
            score[i] = hn::Min(score[i], error);
            choice[i] = hn::IfThenElse(betterI, candidate, choice[i]);
            error = lost;
            candidate = lostCandidate;
        }
    }
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
