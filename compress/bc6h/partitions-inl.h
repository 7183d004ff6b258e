// BC6H: which partitions into two regions are worth a fit, judged by the moments of their texels alone.
#if defined(LIGHTCOOK_COMPRESS_BC6H_PARTITIONS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC6H_PARTITIONS_INL_H_
#undef LIGHTCOOK_COMPRESS_BC6H_PARTITIONS_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC6H_PARTITIONS_INL_H_
#endif

#include <hwy/highway.h>

#include "compress/block/block.h"
#include "compress/block/partitions.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D>
class Bc6hPartitions {
    using F = hn::Vec<D>;
    using DI = hn::RebindToSigned<D>;
    using I = hn::Vec<DI>;
    using M = hn::Mask<D>;
    using Texels = F[kTexelCount];

public:
    static constexpr int kMost = 32;

    /// The `keep` likeliest of the 32, best first, lane by lane.
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
            for (int i = 0; i < keep; ++i) {  // insertion: what is pushed out moves on
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
    static HWY_INLINE F set(float value) { return hn::Set(D(), value); }
    static HWY_INLINE F zero() { return hn::Zero(D()); }

    /// Of the variance along the axis that seven steps leave: a little less than the 1/49 of even steps over even texels, measured.
    static constexpr float kStepShare = 1.0f / 200;

    struct Moments {
        F v[10];  ///< w, wx, wy, wz, wxx, wxy, wxz, wyy, wyz, wzz
    };
    /// Error that is left of texels with these moments on their best line of kSteps + 1 values: what lies off the axis, and the width of a
    /// step. The largest eigenvalue is taken as the norm of the matrix: right where one direction rules, which is where it matters.
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
