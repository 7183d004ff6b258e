// BC6H: the lines of a block, and the assignment of its sixteen texels to one or two regions, each with a line of its own.
#if defined(LIGHTCOOK_COMPRESS_BC6H_REGIONS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC6H_REGIONS_INL_H_
#undef LIGHTCOOK_COMPRESS_BC6H_REGIONS_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC6H_REGIONS_INL_H_
#endif

#include <hwy/highway.h>

#include "compress/block/block.h"
#include "compress/block/partitions.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// The line of a region, in v, from a to a + d.
template <class D>
struct Bc6hLine {
    hn::Vec<D> a[3], d[3];
};

/// One region for all texels.
template <class D>
struct Bc6hOneRegion {
    using F = hn::Vec<D>;
    static constexpr int kCount = 1;
    static constexpr float kSteps = 15.0f;

    /// Returns the weight of a texel in region r, zero if it is in another one.
    static HWY_INLINE F inRegion(int, int, F weight) { return weight; }
    /// Selects the value of the region that holds a texel.
    static HWY_INLINE F pick(int, F first, F) { return first; }
    /// Returns the interpolation weight of an index, in 64ths: 64 i / 15, rounded, as in the format's table.
    static HWY_INLINE F weightOfIndex(F index) { return hn::Round(index * hn::Set(D(), 64.0f / kSteps)); }
};

/// Two regions; each lane has its own partition.
template <class D>
struct Bc6hTwoRegions {
    using F = hn::Vec<D>;
    static constexpr int kCount = 2;
    static constexpr float kSteps = 7.0f;
    static constexpr int kAnchors[3] = {2, 8, 15};  ///< the only anchor texels of region 1 in the 32 partitions
    hn::Mask<D> second[kTexelCount];                ///< lanes where the texel is in region 1
    hn::Mask<D> anchorAt[3];                        ///< lanes whose anchor is kAnchors[i]

    HWY_INLINE F inRegion(int r, int t, F weight) const {
        return r ? hn::IfThenElseZero(second[t], weight) : hn::IfThenZeroElse(second[t], weight);
    }
    HWY_INLINE F pick(int t, F first, F other) const { return hn::IfThenElse(second[t], other, first); }
    static HWY_INLINE F weightOfIndex(F index) { return hn::Round(index * hn::Set(D(), 64.0f / kSteps)); }

    explicit Bc6hTwoRegions(hn::Vec<hn::RebindToSigned<D>> partition) {
        const D d;
        const hn::RebindToSigned<D> di;
        HWY_ALIGN std::int32_t number[hn::MaxLanes(D())], shape[hn::MaxLanes(D())], anchor[hn::MaxLanes(D())];
        hn::Store(partition, di, number);
        for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) {
            shape[lane] = kTwoRegions[static_cast<std::size_t>(number[lane])];
            anchor[lane] = kTwoRegionsAnchor[static_cast<std::size_t>(number[lane])];
        }
        const auto shapes = hn::Load(di, shape), anchors = hn::Load(di, anchor);
        for (int t = 0; t < kTexelCount; ++t) second[t] = hn::RebindMask(d, hn::TestBit(shapes, hn::Set(di, 1 << t)));
        for (int i = 0; i < 3; ++i) anchorAt[i] = hn::RebindMask(d, anchors == hn::Set(di, kAnchors[i]));
    }
};

/// Selects the line of the region that holds texel t.
template <class D, class Regions>
HWY_INLINE void lineAt(const Regions& regions, const Bc6hLine<D>* lines, int t, hn::Vec<D> (&a)[3], hn::Vec<D> (&d)[3]) {
    for (int c = 0; c < 3; ++c) {
        a[c] = regions.pick(t, lines[0].a[c], lines[Regions::kCount - 1].a[c]);
        d[c] = regions.pick(t, lines[0].d[c], lines[Regions::kCount - 1].d[c]);
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
