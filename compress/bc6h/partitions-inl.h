// BC6H: ranks the 32 partitions into two regions by an estimate of their error, from the moments of the texels alone.
//
// The weighted sums of 1, x, y, z and their products over a region give its covariance matrix. The error of the best line is the trace less
// the largest eigenvalue, plus the quantization error along the line, a fixed share of that eigenvalue. The sums of region 0 are those of
// the block less those of region 1.
#if defined(LIGHTCOOK_COMPRESS_BC6H_PARTITIONS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC6H_PARTITIONS_INL_H_
#undef LIGHTCOOK_COMPRESS_BC6H_PARTITIONS_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC6H_PARTITIONS_INL_H_
#endif

#include <hwy/highway.h>

#include "compress/block/block.h"
#include "compress/block/lanes-inl.h"
#include "compress/block/partitions.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D>
class Bc6hPartitions : Lanes<D> {
    using typename Lanes<D>::F, typename Lanes<D>::M, typename Lanes<D>::DI, typename Lanes<D>::I;
    using Lanes<D>::set, Lanes<D>::zero;
    using Texels = F[kTexelCount];

public:
    static constexpr int kMost = 32;

    /// Writes the `keep` partitions of the smallest estimated error to kept, best first.
    /// texels  three channels of sixteen, around any mean
    static void rank(const Texels* texels, const Texels& weight, int keep, I (&kept)[kMost]) {
        Moments moment[kTexelCount], total;
        for (F& v : total.v) v = zero();
        for (int t = 0; t < kTexelCount; ++t) {
            const F w = weight[t], x = texels[0][t], y = texels[1][t], z = texels[2][t];
            const F wx = w * x, wy = w * y, wz = w * z;
            const F all[10] = {w, wx, wy, wz, wx * x, wx * y, wx * z, wy * y, wy * z, wz * z};
            for (int i = 0; i < 10; ++i) {
                moment[t].v[i] = all[i];
                total.v[i] = total.v[i] + all[i];
            }
        }
        F score[kMost];
        for (int i = 0; i < keep; ++i) {
            score[i] = set(1e30f);
            kept[i] = hn::Zero(DI());
        }
        for (int p = 0; p < kMost; ++p) {
            F first[10], second[10];
            for (int i = 0; i < 10; ++i) {
                F sum = zero();
                for (int t = 0; t < kTexelCount; ++t)
                    if ((kTwoRegions[static_cast<std::size_t>(p)] >> t) & 1) sum = sum + moment[t].v[i];
                second[i] = sum;
                first[i] = total.v[i] - sum;
            }
            F error = estimateError(first, kStepShare) + estimateError(second, kStepShare);
            I candidate = hn::Set(DI(), p);
            for (int i = 0; i < keep; ++i) {  // insertion sort: the displaced entry moves on
                const M better = error < score[i];
                const auto betterI = hn::RebindMask(DI(), better);
                const F lost = hn::IfThenElse(better, score[i], error);
                const I lostCandidate = hn::IfThenElse(betterI, kept[i], candidate);
                score[i] = hn::Min(score[i], error);
                kept[i] = hn::IfThenElse(betterI, candidate, kept[i]);
                error = lost;
                candidate = lostCandidate;
            }
        }
    }

private:
    /// Share of the variance along the axis that remains after quantization to seven steps. Measured; below the 1/49 of uniform texels.
    static constexpr float kStepShare = 1.0f / 200;

    struct Moments {
        F v[10];  ///< w, wx, wy, wz, wxx, wxy, wxz, wyy, wyz, wzz
    };
    /// Estimates the error of texels with these moments on their best line: the variance off the axis, and the given share of the variance
    /// along it. The largest eigenvalue is approximated by the Frobenius norm, which is exact if one direction dominates.
    static HWY_INLINE F estimateError(const F (&m)[10], float quantizationShare) {
        const F share = set(1.0f) / hn::Max(m[0], set(1e-30f));
        const F xx = m[4] - m[1] * m[1] * share, xy = m[5] - m[1] * m[2] * share, xz = m[6] - m[1] * m[3] * share;
        const F yy = m[7] - m[2] * m[2] * share, yz = m[8] - m[2] * m[3] * share, zz = m[9] - m[3] * m[3] * share;
        const F norm = hn::Sqrt(xx * xx + yy * yy + zz * zz + set(2.0f) * (xy * xy + xz * xz + yz * yz));
        return hn::Max(xx + yy + zz - norm, zero()) + norm * set(quantizationShare);
    }
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
