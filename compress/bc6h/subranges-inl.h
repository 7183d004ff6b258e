// BC6H: first ends of a line beyond the outermost texels, so that the texels take only a sub-range of the indices.
//
// The ends have few bits, and a block of smooth light spans few codes: then it matters more which codes lie near the line than how many
// indices the texels take. A start places the outermost texels of a region at chosen positions between the first and the last index. The
// line stays the same, so its ends follow by extrapolation. Each start is rounded to codes; its error is computed in v, with the weights of
// refits and nearest indices. Each region keeps its best start. The lists (bc6hSubranges) are ordered by gain: a greedy choice on the eight
// public images and on the pictures of the quality table.
#if defined(LIGHTCOOK_COMPRESS_BC6H_SUBRANGES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC6H_SUBRANGES_INL_H_
#undef LIGHTCOOK_COMPRESS_BC6H_SUBRANGES_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC6H_SUBRANGES_INL_H_
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <cstddef>
#include <span>

#include "compress/bc6h/codes-inl.h"
#include "compress/bc6h/regions-inl.h"
#include "compress/bc6h/search.h"
#include "compress/bc6h/texels-inl.h"
#include "compress/bc6h/values-inl.h"
#include "compress/block/lanes-inl.h"
#include "compress/block/principal_axis-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D, bool kSigned>
class Bc6hSubranges : Lanes<D> {
    using typename Lanes<D>::F, typename Lanes<D>::M;
    using Lanes<D>::set, Lanes<D>::zero, Lanes<D>::clamp, Lanes<D>::select;
    using Values = Bc6hValues<D, kSigned>;
    using Codes = Bc6hCodes<D, kSigned>;
    using ModeLanes = typename Codes::ModeLanes;
    using Line = Bc6hLine<D>;

public:
    using Weights = F[3][kTexelCount];

    /// Binds the texels of a vector of blocks, and the weight of a squared error in v. Both must outlive this object.
    Bc6hSubranges(const Bc6hTexels<D, kSigned>& texels, const Weights& weight) : texels_(texels), weight_(weight) {}

    /// Moves the ends of each line to those of the best of the first `count` starts. The ends are not rounded.
    /// mode  whose codes the starts are rounded to. Ends whose deltas do not fit are clamped
    template <class Regions>
    void chooseStart(const Regions& regions, const ModeLanes& mode, int count, Line* lines) const {
        F low[2], range[2];
        findRanges(regions, lines, low, range);
        F least[2];
        Line best[2];
        for (int r = 0; r < Regions::kCount; ++r) {
            least[r] = set(1e30f);
            best[r] = lines[r];
        }
        const std::span<const Bc6hSubrange> starts = bc6hSubranges(Regions::kCount);
        for (const Bc6hSubrange& start : starts.first(std::min(static_cast<std::size_t>(count), starts.size()))) {
            const float perRange = 1 / (Regions::kSteps - start.freeLow - start.freeHigh);
            const F before = set(start.freeLow * perRange), after = set((Regions::kSteps - start.freeLow) * perRange);
            Line line[2], whole[2];
            for (int r = 0; r < Regions::kCount; ++r) {
                const F first = hn::NegMulAdd(range[r], before, low[r]), last = hn::MulAdd(range[r], after, low[r]);
                for (int c = 0; c < 3; ++c) {
                    line[r].a[c] = inRange(hn::MulAdd(lines[r].d[c], first, lines[r].a[c]));
                    line[r].d[c] = inRange(hn::MulAdd(lines[r].d[c], last, lines[r].a[c])) - line[r].a[c];
                }
            }
            F code[4][3], error[2];
            Codes::codesOf(regions, line, mode, code);
            Codes::clampDeltas(regions, mode, code);
            Codes::linesOf(regions, code, mode, whole);
            errorsOf(regions, whole, error);
            for (int r = 0; r < Regions::kCount; ++r) {
                const M better = error[r] < least[r];
                least[r] = hn::Min(error[r], least[r]);
                for (int c = 0; c < 3; ++c) {
                    best[r].a[c] = select(better, line[r].a[c], best[r].a[c]);
                    best[r].d[c] = select(better, line[r].d[c], best[r].d[c]);
                }
            }
        }
        for (int r = 0; r < Regions::kCount; ++r) lines[r] = best[r];
    }

private:
    static HWY_INLINE F inRange(F v) { return clamp(v, set(Values::kSmallest), set(Values::kLargest)); }

    /// Finds the range of the positions of the significant texels of each region on its line.
    template <class Regions>
    void findRanges(const Regions& regions, const Line* lines, F* low, F* range) const {
        F position[kTexelCount];
        for (int t = 0; t < kTexelCount; ++t) {
            F a[3], d[3];
            lineAt<D>(regions, lines, t, a, d);
            F along = zero(), length = set(1e-20f);
            for (int c = 0; c < 3; ++c) {
                const F wd = weight_[c][t] * d[c];
                along = hn::MulAdd(wd, texels_.target[c][t] - a[c], along);
                length = hn::MulAdd(wd, d[c], length);
            }
            position[t] = along * roughInverse<D>(length);
        }
        for (int r = 0; r < Regions::kCount; ++r) {
            F high = set(-1e30f);
            low[r] = set(1e30f);
            for (int t = 0; t < kTexelCount; ++t) {
                const M counts = regions.inRegion(r, t, texels_.significance[t]) > zero();
                low[r] = select(counts, hn::Min(low[r], position[t]), low[r]);
                high = select(counts, hn::Max(high, position[t]), high);
            }
            range[r] = high - low[r];
        }
    }

    /// Computes the weighted squared error in v of each region, with the nearest indices. A texel at position k of a line has the error
    /// `base + k^2 length - 2 k along`.
    template <class Regions>
    HWY_INLINE void errorsOf(const Regions& regions, const Line* lines, F* error) const {
        const F steps = set(Regions::kSteps), perStep = set(1.0f / Regions::kSteps);
        for (int r = 0; r < Regions::kCount; ++r) error[r] = zero();
        for (int t = 0; t < kTexelCount; ++t) {
            F a[3], d[3];
            lineAt<D>(regions, lines, t, a, d);
            F along = zero(), length = set(1e-20f), base = zero();
            for (int c = 0; c < 3; ++c) {
                const F away = texels_.target[c][t] - a[c], wd = weight_[c][t] * d[c];
                base = hn::MulAdd(weight_[c][t] * away, away, base);
                along = hn::MulAdd(wd, away, along);
                length = hn::MulAdd(wd, d[c], length);
            }
            const F k = hn::Round(clamp(along * roughInverse<D>(length) * steps, zero(), steps)) * perStep;
            const F left = hn::MulAdd(k, hn::MulSub(k, length, along + along), base);
            for (int r = 0; r < Regions::kCount; ++r) error[r] = error[r] + regions.inRegion(r, t, left);
        }
    }

    const Bc6hTexels<D, kSigned>& texels_;
    const Weights& weight_;
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
