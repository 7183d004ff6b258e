// BC7: ranks partitions by an estimate of their error, from the moments of the texels alone.
//
// The weighted sums of 1, the channels and their products over a region give its covariance matrix. The error of the best line is the trace
// less the largest eigenvalue, plus the quantization error along the line, a fixed share of that eigenvalue. The sums of region 0 are those
// of the block less those of the other regions.
#if defined(LIGHTCOOK_COMPRESS_BC7_PARTITIONS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC7_PARTITIONS_INL_H_
#undef LIGHTCOOK_COMPRESS_BC7_PARTITIONS_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC7_PARTITIONS_INL_H_
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <cmath>

#include "compress/bc7/lines-inl.h"
#include "compress/block/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D>
class Bc7Partitions : Lanes<D> {
    using typename Lanes<D>::F, typename Lanes<D>::M, typename Lanes<D>::DI, typename Lanes<D>::I;
    using Lanes<D>::set, Lanes<D>::zero, Lanes<D>::select;

public:
    static constexpr int kMostKept = 64;
    /// Partitions and their estimated errors, best first.
    struct Ranking {
        F score[kMostKept];
        I partition[kMostKept];
    };

    Bc7Partitions(const Bc7View<D>& view, const F (&significance)[kTexelCount]) {
        for (F& v : total_.v) v = zero();
        F mean[4] = {zero(), zero(), zero(), zero()}, weight = zero();
        for (int t = 0; t < kTexelCount; ++t) {
            weight = weight + significance[t];
            for (int c = 0; c < 4; ++c) mean[c] = mean[c] + significance[t] * view.channel[c][t];
        }
        const F perWeight = set(1.0f) / weight;
        for (int t = 0; t < kTexelCount; ++t) {
            F away[4];
            for (int c = 0; c < 4; ++c) away[c] = (view.channel[c][t] - mean[c] * perWeight) * set(std::sqrt(view.weight[c]));
            F* out = moment_[t].v;
            *out++ = significance[t];
            for (int c = 0; c < 4; ++c) *out++ = significance[t] * away[c];
            for (int i = 0; i < 4; ++i)
                for (int j = i; j < 4; ++j) *out++ = significance[t] * away[i] * away[j];
            for (int i = 0; i < kMoments; ++i) total_.v[i] = total_.v[i] + moment_[t].v[i];
        }
    }

    /// Ranks the first `shapes` partitions into two regions and keeps the best ones.
    void rankTwo(int shapes, int keep, Ranking& ranking) const {
        clear(keep, ranking);
        for (int p = 0; p < shapes; ++p) {
            F first[kMoments], second[kMoments];
            for (int i = 0; i < kMoments; ++i) {
                F sum = zero();
                for (int t = 0; t < kTexelCount; ++t)
                    if (regionOf(2, p, t) == 1) sum = sum + moment_[t].v[i];
                second[i] = sum;
                first[i] = total_.v[i] - sum;
            }
            insert(estimateError(first, kQuantizationShare) + estimateError(second, kQuantizationShare), p, keep, ranking);
        }
    }

    /// Ranks the partitions into three regions, and the first sixteen of them separately.
    void rankThree(int keep, int keepFirst, Ranking& all, Ranking& first16) const {
        clear(keep, all);
        clear(keepFirst, first16);
        for (int p = 0; p < 64; ++p) {
            F sums[3][kMoments];
            for (int i = 0; i < kMoments; ++i) {
                sums[1][i] = sums[2][i] = zero();
                for (int t = 0; t < kTexelCount; ++t) {
                    const int r = regionOf(3, p, t);
                    if (r > 0) sums[r][i] = sums[r][i] + moment_[t].v[i];
                }
                sums[0][i] = total_.v[i] - sums[1][i] - sums[2][i];
            }
            F error = zero();
            for (const auto& sum : sums) error = error + estimateError(sum, kQuantizationShare);
            insert(error, p, keep, all);
            if (p < 16) insert(error, p, keepFirst, first16);
        }
    }

private:
    static constexpr int kMoments = 15;
    /// Share of the variance along the axis that is expected to remain after quantization: that of uniform texels in seven steps.
    static constexpr float kQuantizationShare = 1.0f / 49;
    struct Moments {
        F v[kMoments];  ///< w; w times each channel; w times each product of two channels
    };

    /// Estimates the error of texels with these moments on their best line: the variance off the axis, and the given share of the variance
    /// along it. The largest eigenvalue is approximated by the Frobenius norm, which is exact if one direction dominates.
    static HWY_INLINE F estimateError(const F* m, float quantizationShare) {
        const F perTotal = set(1.0f) / hn::Max(m[0], set(1e-30f));
        F trace = zero(), squares = zero();
        int at = 5;
        for (int i = 0; i < 4; ++i)
            for (int j = i; j < 4; ++j) {
                const F v = m[at++] - m[1 + i] * m[1 + j] * perTotal;
                if (i == j) trace = trace + v;
                squares = squares + (i == j ? v * v : set(2.0f) * v * v);
            }
        const F norm = hn::Sqrt(squares);
        return hn::Max(trace - norm, zero()) + norm * set(quantizationShare);
    }
    /// Inserts a partition into the sorted ranking.
    static void insert(F error, int partition, int keep, Ranking& ranking) {
        I candidate = hn::Set(DI(), partition);
        for (int i = 0; i < keep; ++i) {  // the displaced entry moves on
            const M better = error < ranking.score[i];
            const auto betterI = hn::RebindMask(DI(), better);
            const F lost = select(better, ranking.score[i], error);
            const I lostCandidate = hn::IfThenElse(betterI, ranking.partition[i], candidate);
            ranking.score[i] = hn::Min(ranking.score[i], error);
            ranking.partition[i] = hn::IfThenElse(betterI, candidate, ranking.partition[i]);
            error = lost;
            candidate = lostCandidate;
        }
    }
    static void clear(int keep, Ranking& ranking) {
        for (int i = 0; i < keep; ++i) {
            ranking.score[i] = set(1e30f);
            ranking.partition[i] = hn::Zero(DI());
        }
    }

    Moments moment_[kTexelCount], total_;
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
