// BC7 at low effort: one block in each lane, from rows of texels to packed blocks without gathering blocks.
//
// Method. Every mode is fitted in closed form: a line along the principal axis of a region, the indices nearest to it, the least-squares
// ends for these, and the codes and low bits of least error, all from sums over the texels (closed_form/least_squares-inl.h). The error of
// a candidate follows from the same sums. Candidates, with the counts given by Bc7FastSearch:
// 1. Mode 6: one line in four channels.
// 2. Mode 5 with alpha as the separate channel.
// 3. Modes 1 and 3 (opaque blocks) and 7 (others): two regions, in the partitions of least predicted error
//    (closed_form/partition_ranking-inl.h), if that is below the error of the candidates before.
// Only the best candidate of each lane gets its final indices and is packed. Blocks of one colour are encoded by the caller (rows-inl.h).
#if defined(LIGHTCOOK_COMPRESS_BC7_FAST_KERNEL_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC7_FAST_KERNEL_INL_H_
#undef LIGHTCOOK_COMPRESS_BC7_FAST_KERNEL_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC7_FAST_KERNEL_INL_H_
#endif

#include <hwy/highway.h>

#include <array>
#include <cstddef>
#include <span>

#include "compress/bc7/closed_form/least_squares-inl.h"
#include "compress/bc7/closed_form/partition_ranking-inl.h"
#include "compress/bc7/closed_form/plane-inl.h"
#include "compress/bc7/closed_form/region_fit-inl.h"
#include "compress/bc7/closed_form/texels-inl.h"
#include "compress/bc7/fast/block-inl.h"
#include "compress/bc7/search.h"
#include "compress/block/block.h"
#include "compress/block/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D>
class Bc7Fast : Lanes<D> {
    using typename Lanes<D>::F, typename Lanes<D>::M, typename Lanes<D>::DI, typename Lanes<D>::I;
    using Lanes<D>::set, Lanes<D>::zero, Lanes<D>::select;
    using Ends = Bc7RoundedEnds<D>;

public:
    Bc7Fast(const Bc7FastSearch& search, const EncodeOptions& options) : search_(search), texels_(options) {}

    /// Encodes Lanes(d) blocks with one region, and writes 16 bytes for each of the first `count`.
    /// texels, weights  as for Bc7ScaledTexels::load
    /// Returns true if a value was clamped into the range of the format.
    bool runOneRegion(const std::array<const float*, 4>& texels, const std::array<const float*, 4>* weights, std::size_t count,
                      std::byte* out) {
        const bool clamped = texels_.load(texels, weights);
        block_.clear(set(1e30f));
        texels_.products(product_);
        Bc7RegionFit<D, 1, 4> whole(texels_, kAll, hn::Zero(DI()));
        whole.start(product_, kIterations);
        Ends ends[1];
        const M everywhere = zero() == zero();
        F error = whole.fit(6, 7, 4, search_.refits, ends);
        if (search_.exactBelow > 0) {
            const M fine = error < texels_.total * set(4 * search_.exactBelow * search_.exactBelow);
            if (!hn::AllFalse(D(), fine)) whole.roundExactly(7, 4, fine, ends[0], error);
        }
        block_.template keep<1, 4>(everywhere, zero(), error, 6, hn::Zero(DI()), ends);
        if (search_.mode5) tryMode5();
        block_.finish(texels_, count, [&](std::size_t lane) { return out + 16 * lane; });
        return clamped;
    }
    /// Encodes blocks with two regions, and writes those that are better than with one.
    /// error  of each block with one region
    /// out    where each block goes; one for each of the first lanes
    void runTwoRegions(const std::array<const float*, 4>& texels, const std::array<const float*, 4>& weights, F error,
                       std::span<std::byte* const> out) {
        texels_.load(texels, &weights);
        block_.clear(error);
        texels_.products(product_);
        tryTwoRegions();
        HWY_ALIGN float better[hn::MaxLanes(D())];
        const M isBetter = block_.error < error;
        if (hn::AllFalse(D(), isBetter)) return;
        hn::Store(hn::IfThenElseZero(isBetter, set(1.0f)), D(), better);
        block_.finish(texels_, out.size(), [&](std::size_t lane) { return better[lane] > 0 ? out[lane] : nullptr; });
    }
    const Bc7ScaledTexels<D>& texels() const { return texels_; }
    /// Returns the error of each block, see Bc7ScaledTexels, without the rounding of interpolated values.
    F error() const { return block_.error; }

private:
    static constexpr std::size_t kAll[4] = {0, 1, 2, 3}, kColours[3] = {0, 1, 2};

    static constexpr int kIterations = 2;  ///< of the power iterations
    /// Share of the variance along a line that the ranking expects as quantization error.
    static constexpr float kQuantization = 1.0f / 144;
    /// Share of the variance outside the plane of the ranking that is expected to remain.
    static constexpr float kOutsideShare = 0.5f;

    /// Fits mode 5 with alpha as the separate channel.
    void tryMode5() {
        constexpr Bc7Mode kMode = kBc7Modes[5];
        const F product[6] = {product_[0], product_[1], product_[2], product_[4], product_[5], product_[7]};
        Bc7RegionFit<D, 1, 3> colour(texels_, kColours, hn::Zero(DI()));
        colour.start(product, kIterations);
        static constexpr std::size_t kAlpha[1] = {3};
        const F alphaProduct[1] = {product_[9]};
        Bc7RegionFit<D, 1, 1> alpha(texels_, kAlpha, hn::Zero(DI()));
        alpha.start(alphaProduct, 0);
        Ends ends[1], alphaEnds[1];
        const F error = colour.fit(5, kMode.colourBits, kMode.indexBits, search_.refits, ends) +
                        alpha.fit(5, kMode.alphaBits, kMode.secondIndexBits, search_.refits, alphaEnds);
        block_.keepMode5(error, ends, alphaEnds);
    }

    /// Fits the partitions with the least predicted error to modes 1 and 3, or 7.
    void tryTwoRegions() {
        Bc7RegionFit<D, 1, 4> whole(texels_, kAll, hn::Zero(DI()));
        whole.start(product_, kIterations);
        const Bc7Plane<D> plane(texels_, whole, product_, kIterations);
        Bc7Ranking<D> ranking(search_.partitions);
        Bc7PartitionRanking<D>(texels_, plane.p, plane.q, kQuantization).rankTwo(search_.shapes, ranking);
        const bool anyOpaque = !hn::AllFalse(D(), texels_.opaque), anyAlpha = !hn::AllFalse(D(), texels_.hasAlpha);
        for (int i = 0; i < search_.partitions; ++i) {
            const M promising =
                hn::AndNot(texels_.constant, hn::MulAdd(plane.outside, set(kOutsideShare), ranking.score[i]) < block_.error);
            if (hn::AllFalse(D(), promising)) continue;
            if (anyOpaque) {
                const F product[6] = {product_[0], product_[1], product_[2], product_[4], product_[5], product_[7]};
                Bc7RegionFit<D, 2, 3> two(texels_, kColours, ranking.choice[i]);
                two.start(product, kIterations);
                keepTwo(two, 1, hn::And(texels_.opaque, promising), ranking.choice[i]);
                if (search_.mode3) keepTwo(two, 3, hn::And(texels_.opaque, promising), ranking.choice[i]);
            }
            if (anyAlpha) {
                Bc7RegionFit<D, 2, 4> two(texels_, kAll, ranking.choice[i]);
                two.start(product_, kIterations);
                keepTwo(two, 7, hn::And(texels_.hasAlpha, promising), ranking.choice[i]);
            }
        }
    }
    template <int kChannels>
    void keepTwo(const Bc7RegionFit<D, 2, kChannels>& regions, int mode, M allowed, I choice) {
        const Bc7Mode& m = kBc7Modes[static_cast<std::size_t>(mode)];
        Ends ends[2];
        F error = regions.fit(mode, m.colourBits, m.indexBits, search_.refits, ends);
        if (kChannels == 3) error = error + texels_.opaqueError;
        block_.template keep<2, kChannels>(allowed, set(255 * texels_.scale[3]), error, mode, choice, ends);
    }

    const Bc7FastSearch& search_;
    Bc7ScaledTexels<D> texels_;
    Bc7FastBlock<D> block_;
    F product_[10];  ///< see Bc7ScaledTexels::products
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
