// BC7, closed forms: predicts the best partitions into two or three regions from moments in the plane of the two principal axes.
//
// The error of the best line of a region is the smaller eigenvalue of its covariance matrix, which is a closed form for a 2 x 2 matrix. The
// variance outside the plane is left out, since it differs little between partitions. Quantization adds a fixed share of the larger
// eigenvalue. The sums of a region are those of its parts of the four rows of texels, which are computed once for each of the 16 subsets
// of a row.
#if defined(LIGHTCOOK_COMPRESS_BC7_CLOSED_FORM_PARTITION_RANKING_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC7_CLOSED_FORM_PARTITION_RANKING_INL_H_
#undef LIGHTCOOK_COMPRESS_BC7_CLOSED_FORM_PARTITION_RANKING_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC7_CLOSED_FORM_PARTITION_RANKING_INL_H_
#endif

#include <hwy/highway.h>

#include <array>
#include <bit>
#include <cstddef>

#include "compress/bc7/closed_form/least_squares-inl.h"
#include "compress/bc7/closed_form/texels-inl.h"
#include "compress/block/lanes-inl.h"
#include "compress/block/partitions.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Partitions and their predicted errors, best first, without the variance outside the plane.
template <class D>
struct Bc7Ranking {
    static constexpr int kMost = 64;
    int keep;  ///< number of partitions that are kept, at least 1
    hn::Vec<D> score[kMost];
    /// Number of the partition in the low 6 bits; of two regions, the texels of region 1 in the high 16.
    hn::Vec<hn::RebindToSigned<D>> choice[kMost];

    explicit Bc7Ranking(int count) : keep(count) {
        for (int i = 0; i < keep; ++i) {
            score[i] = hn::Set(D(), 1e30f);
            choice[i] = hn::Zero(hn::RebindToSigned<D>());
        }
    }
    HWY_INLINE void insert(hn::Vec<D> error, std::uint32_t number) {
        auto candidate = hn::Set(hn::RebindToSigned<D>(), static_cast<std::int32_t>(number));
        for (int i = 0; i < keep; ++i) {  // the displaced entry moves on
            const auto better = error < score[i];
            const auto betterI = hn::RebindMask(hn::RebindToSigned<D>(), better);
            const auto lost = hn::IfThenElse(better, score[i], error);
            const auto lostCandidate = hn::IfThenElse(betterI, choice[i], candidate);
            score[i] = hn::IfThenElse(better, error, score[i]);  // not Min: an error that is no number is never better
            choice[i] = hn::IfThenElse(betterI, candidate, choice[i]);
            error = lost;
            candidate = lostCandidate;
        }
    }
};

template <class D>
class Bc7PartitionRanking : Lanes<D> {
    using typename Lanes<D>::F, typename Lanes<D>::DI;
    using Lanes<D>::set, Lanes<D>::zero;
    using Ranking = Bc7Ranking<D>;

public:
    /// p, q          positions of the texels on the principal axes, about their mean
    /// quantization  share of the variance along a line that quantization adds
    Bc7PartitionRanking(const Bc7ScaledTexels<D>& texels, const F (&p)[kTexelCount], const F (&q)[kTexelCount], float quantization)
        : uniform_(texels.uniform), traceShare_(set(0.5f + 0.5f * quantization)), rootShare_(set(0.5f - 0.5f * quantization)) {
        if (uniform_)
            load<true>(texels, p, q);
        else
            load<false>(texels, p, q);
    }

    /// Ranks the first `count` partitions into two regions.
    void rankTwo(int count, Ranking& ranking) const { uniform_ ? rankTwo<true>(count, ranking) : rankTwo<false>(count, ranking); }
    /// Ranks all partitions into three regions, and the first sixteen of them separately.
    void rankThree(Ranking& all, Ranking& first16) const { uniform_ ? rankThree<true>(all, first16) : rankThree<false>(all, first16); }

private:
    static constexpr int kSums = 6;  ///< p, q, pp, pq, qq; the weight unless all are 1
    using Sums = F[kSums];
    static constexpr std::array<float, kTexelCount> kInverse = [] {
        std::array<float, kTexelCount> inverse{};
        for (std::size_t n = 1; n < inverse.size(); ++n) inverse[n] = 1 / static_cast<float>(n);
        return inverse;
    }();
    template <bool kUniform>
    static constexpr int kUsed = kUniform ? kSums - 1 : kSums;

    template <bool kUniform>
    void load(const Bc7ScaledTexels<D>& texels, const F (&p)[kTexelCount], const F (&q)[kTexelCount]) {
        for (std::size_t y = 0; y < 4; ++y)
            for (std::size_t subset = 0; subset < 16; ++subset) {
                F* to = part_[y][subset];
                if (subset == 0) {
                    for (int i = 0; i < kUsed<kUniform>; ++i) to[i] = zero();
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
                    const F *one = part_[y][subset & (subset - 1)], *other = part_[y][subset & (~subset + 1)];
                    for (int i = 0; i < kUsed<kUniform>; ++i) to[i] = one[i] + other[i];
                }
            }
        addRows<kUniform>(0xFFFF, all_);
    }
    /// Adds up the sums of the texels in a mask.
    template <bool kUniform>
    HWY_INLINE void addRows(std::uint32_t mask, Sums& sums) const {
        const F *r0 = part_[0][mask & 15], *r1 = part_[1][(mask >> 4) & 15], *r2 = part_[2][(mask >> 8) & 15], *r3 = part_[3][mask >> 12];
        for (int i = 0; i < kUsed<kUniform>; ++i) sums[i] = r0[i] + r1[i] + (r2[i] + r3[i]);
    }
    template <bool kUniform>
    static HWY_INLINE F inverseOf(const Sums& sums, int count) {
        return kUniform ? set(kInverse[static_cast<std::size_t>(count)]) : Bc7LeastSquares<D>::inverse(sums[kSums - 1]);
    }
    F errorOf(F trace, F root) const { return hn::NegMulAdd(root, rootShare_, trace * traceShare_); }

    template <bool kUniform>
    void rankTwo(int count, Ranking& ranking) const {
        for (int number = 0; number < count; ++number) {
            const std::uint32_t mask = kTwoRegions[static_cast<std::size_t>(number)];
            Sums second, first;
            addRows<kUniform>(mask, second);
            for (int i = 0; i < kUsed<kUniform>; ++i) first[i] = all_[i] - second[i];
            const int inSecond = std::popcount(mask);
            F trace = zero(), root = zero();
            addRegion(first, inverseOf<kUniform>(first, kTexelCount - inSecond), trace, root);
            addRegion(second, inverseOf<kUniform>(second, inSecond), trace, root);
            ranking.insert(errorOf(trace, root), mask << 16 | static_cast<std::uint32_t>(number));
        }
    }
    template <bool kUniform>
    void rankThree(Ranking& all, Ranking& first16) const {
        for (std::size_t number = 0; number < 64; ++number) {
            const std::uint32_t mask = kThreeRegionsMask[0][number], thirdMask = kThreeRegionsMask[1][number];
            Sums first, second, third;
            addRows<kUniform>(mask, second);
            addRows<kUniform>(thirdMask, third);
            for (int i = 0; i < kUsed<kUniform>; ++i) first[i] = all_[i] - second[i] - third[i];
            const int inSecond = std::popcount(mask), inThird = std::popcount(thirdMask);
            F trace = zero(), root = zero();
            addRegion(first, inverseOf<kUniform>(first, kTexelCount - inSecond - inThird), trace, root);
            addRegion(second, inverseOf<kUniform>(second, inSecond), trace, root);
            addRegion(third, inverseOf<kUniform>(third, inThird), trace, root);
            const F error = errorOf(trace, root);
            all.insert(error, static_cast<std::uint32_t>(number));
            if (number < 16) first16.insert(error, static_cast<std::uint32_t>(number));
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

    bool uniform_;
    F traceShare_, rootShare_;
    F part_[4][16][kSums];  ///< of each subset of each row
    Sums all_;
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
