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

#include <cstddef>

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
        // Sums over the texels of a row that are in region 1, for each pattern of them.
        F row[4][16][10];
        for (int y = 0; y < 4; ++y) {
            for (int x = 0; x < 4; ++x) {
                const int t = 4 * y + x;
                const F w = weight[t], a = texels[0][t], b = texels[1][t], c = texels[2][t];
                const F wa = w * a, wb = w * b, wc = w * c;
                const F all[10] = {w, wa, wb, wc, wa * a, wa * b, wa * c, wb * b, wb * c, wc * c};
                for (int i = 0; i < 10; ++i) row[y][1 << x][i] = all[i];
            }
            for (int pattern = 3; pattern < 16; ++pattern) {
                const int lowest = pattern & -pattern;
                if (pattern == lowest) continue;
                for (int i = 0; i < 10; ++i) row[y][pattern][i] = row[y][pattern & ~lowest][i] + row[y][lowest][i];
            }
        }
        F total[10];
        for (int i = 0; i < 10; ++i) total[i] = (row[0][15][i] + row[1][15][i]) + (row[2][15][i] + row[3][15][i]);
        F score[kMost];
        for (int i = 0; i < keep; ++i) {
            score[i] = set(1e30f);
            kept[i] = hn::Zero(DI());
        }
        for (int p = 0; p < kMost; ++p) {
            F first[10], second[10];
            for (F& sum : second) sum = zero();
            for (int y = 0; y < 4; ++y) {
                const int pattern = kTwoRegions[static_cast<std::size_t>(p)] >> 4 * y & 15;
                if (pattern == 0) continue;
                for (int i = 0; i < 10; ++i) second[i] = second[i] + row[y][pattern][i];
            }
            for (int i = 0; i < 10; ++i) first[i] = total[i] - second[i];
            F error = estimateError(first, kStepShare) + estimateError(second, kStepShare);
            I candidate = hn::Set(DI(), p);
            for (int i = 0; i < keep; ++i) {  // insertion sort: the displaced entry moves on
                const M better = error < score[i];
                const auto betterI = hn::RebindMask(DI(), better);
                const F lost = hn::IfThenElse(better, score[i], error);
                const I lostCandidate = hn::IfThenElse(betterI, kept[i], candidate);
                score[i] = hn::IfThenElse(better, error, score[i]);  // not Min: an error that is no number is never better
                kept[i] = hn::IfThenElse(betterI, candidate, kept[i]);
                error = lost;
                candidate = lostCandidate;
            }
        }
    }

private:
    /// Share of the variance along the axis that remains after quantization to seven steps. Measured; below the 1/49 of uniform texels.
    static constexpr float kStepShare = 1.0f / 200;

    /// Estimates the error of texels with these moments (w, wx, wy, wz, wxx, wxy, wxz, wyy, wyz, wzz) on their best line: the variance off
    /// the axis, and the given share of the variance along it. The largest eigenvalue is approximated by the Frobenius norm, which is exact
    /// if one direction dominates.
    static HWY_INLINE F estimateError(const F (&m)[10], float quantizationShare) {
        const F perTotal = set(1.0f) / hn::Max(m[0], set(1e-30f));
        const F x = m[1] * perTotal, y = m[2] * perTotal, z = m[3] * perTotal;
        const F xx = hn::NegMulAdd(m[1], x, m[4]), xy = hn::NegMulAdd(m[1], y, m[5]), xz = hn::NegMulAdd(m[1], z, m[6]);
        const F yy = hn::NegMulAdd(m[2], y, m[7]), yz = hn::NegMulAdd(m[2], z, m[8]), zz = hn::NegMulAdd(m[3], z, m[9]);
        const F norm = hn::Sqrt(
            hn::MulAdd(set(2.0f), hn::MulAdd(xy, xy, hn::MulAdd(xz, xz, yz * yz)), hn::MulAdd(xx, xx, hn::MulAdd(yy, yy, zz * zz))));
        return hn::Max(xx + yy + zz - norm, zero()) + norm * set(quantizationShare);
    }
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
