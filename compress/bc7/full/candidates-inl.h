// BC7, full search: the modes, partitions and rotations of least predicted error, one block in each lane.
//
// Method. Every candidate is fitted in closed form, as in the fast kernel (closed_form/least_squares-inl.h): the predicted error leaves out
// only the rounding of interpolated values. Partitions into two and three regions are ranked first (closed_form/partition_ranking-inl.h),
// and the best ones are fitted. The counts are those of Bc7Search.
#if defined(LIGHTCOOK_COMPRESS_BC7_FULL_CANDIDATES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC7_FULL_CANDIDATES_INL_H_
#undef LIGHTCOOK_COMPRESS_BC7_FULL_CANDIDATES_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC7_FULL_CANDIDATES_INL_H_
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <cstddef>

#include "compress/bc7/closed_form/least_squares-inl.h"
#include "compress/bc7/closed_form/partition_ranking-inl.h"
#include "compress/bc7/closed_form/plane-inl.h"
#include "compress/bc7/closed_form/region_fit-inl.h"
#include "compress/bc7/closed_form/texels-inl.h"
#include "compress/bc7/search.h"
#include "compress/block/block.h"
#include "compress/block/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D>
class Bc7Candidates : Lanes<D> {
    using typename Lanes<D>::F, typename Lanes<D>::M, typename Lanes<D>::DI, typename Lanes<D>::I;
    using Lanes<D>::set, Lanes<D>::zero, Lanes<D>::select;
    using Ends = Bc7RoundedEnds<D>;
    template <int kRegions, int kChannels>
    using Regions = Bc7RegionFit<D, kRegions, kChannels>;

public:
    Bc7Candidates(const Bc7Search& search, const EncodeOptions& options) : search_(search), texels_(options) {}

    /// Finds the best candidates of Lanes(d) blocks.
    void find(const Block* const* blocks) {
        for (int i = 0; i < search_.polished; ++i) {
            error_[i] = set(1e30f);
            number_[i] = hn::Set(DI(), i == 0 ? Bc7Candidate{6}.number() : Bc7Candidate::kNone);
        }
        texels_.load(blocks);
        texels_.products(product_);
        Regions<1, 4> whole(texels_, kAll, hn::Zero(DI()));
        whole.start(product_, kIterations);
        tryOneRegion(whole);
        for (int rotation = 0; search_.twoIndices && rotation < 4; ++rotation) tryTwoIndices(rotation);
        if (search_.twoRegions > 0) tryPartitions(whole);
    }
    /// Writes the numbers of the candidates (Bc7Candidate), best first: search.polished for each lane, some of which may be kNone.
    void store(std::int32_t* out) const {
        HWY_ALIGN std::int32_t buffer[hn::MaxLanes(D())];
        // Predicted errors near 0 may be below it by rounding.
        const F limit = hn::MulAdd(hn::Max(error_[0], zero()), set(search_.promising), texels_.total * set(kRounding));
        for (int i = 0; i < search_.polished; ++i) {
            const auto promising = hn::RebindMask(DI(), error_[i] <= limit);
            hn::Store(hn::IfThenElse(promising, number_[i], hn::Set(DI(), Bc7Candidate::kNone)), DI(), buffer);
            for (std::size_t lane = 0; lane < hn::Lanes(D()); ++lane)
                out[lane * static_cast<std::size_t>(search_.polished) + static_cast<std::size_t>(i)] = buffer[lane];
        }
    }

private:
    static constexpr std::size_t kAll[4] = {0, 1, 2, 3}, kColours[3] = {0, 1, 2};
    static constexpr int kIterations = 2;  ///< of the power iterations
    /// Share of the variance along a line that the ranking expects as quantization error.
    static constexpr float kQuantization = 1.0f / 144;
    /// The rounding of interpolated values adds about this to the squared error of a texel [8-bit codes^2]; predictions leave it out.
    static constexpr float kRounding = 0.2f;

    void insert(M allowed, F error, I number) {
        error = select(allowed, error, set(1e30f));
        for (int i = 0; i < search_.polished; ++i) {  // the displaced entry moves on
            const M better = error < error_[i];
            const auto betterI = hn::RebindMask(DI(), better);
            const F lost = select(better, error_[i], error);
            const I lostNumber = hn::IfThenElse(betterI, number_[i], number);
            error_[i] = select(better, error, error_[i]);  // not Min: an error that is no number is never better
            number_[i] = hn::IfThenElse(betterI, number, number_[i]);
            error = lost;
            number = lostNumber;
        }
    }
    void insert(F error, const Bc7Candidate& candidate) { insert(zero() == zero(), error, hn::Set(DI(), candidate.number())); }

    /// whole  the block as one region, started
    void tryOneRegion(const Regions<1, 4>& whole) {
        Ends ends[1];
        insert(whole.fit(6, kBc7Modes[6].colourBits, kBc7Modes[6].indexBits, search_.refits, ends), {6});
    }

    /// Fits modes 5 and 4, in which one channel has indices of its own.
    void tryTwoIndices(int rotation) {
        const std::size_t colours[3] = {rotatedChannel(rotation, 0), rotatedChannel(rotation, 1), rotatedChannel(rotation, 2)};
        const std::size_t separate = rotatedChannel(rotation, 3);
        const auto productOf = [&](std::size_t a, std::size_t b) {
            const std::size_t i = std::min(a, b), j = std::max(a, b);
            return product_[i * 4 - i * (i - 1) / 2 + j - i];
        };
        F products[6];
        for (std::size_t i = 0, at = 0; i < 3; ++i)
            for (std::size_t j = i; j < 3; ++j) products[at++] = productOf(colours[i], colours[j]);
        Regions<1, 3> colour(texels_, colours, hn::Zero(DI()));
        colour.start(products, kIterations);
        const std::size_t other[1] = {separate};
        const F otherProduct[1] = {productOf(separate, separate)};
        Regions<1, 1> alone(texels_, other, hn::Zero(DI()));
        alone.start(otherProduct, 0);
        const auto tryMode = [&](int mode, int selection) {
            const Bc7Mode& m = kBc7Modes[static_cast<std::size_t>(mode)];
            Ends ends[1];
            const int colourIndexBits = selection ? m.secondIndexBits : m.indexBits,
                      otherIndexBits = m.indexBits + m.secondIndexBits - colourIndexBits;
            const F error = colour.fit(mode, m.colourBits, colourIndexBits, search_.refits, ends) +
                            alone.fit(mode, m.alphaBits, otherIndexBits, search_.refits, ends);
            insert(error, {mode, 0, rotation, selection});
        };
        tryMode(5, 0);
        tryMode(4, 0);
        tryMode(4, 1);
    }

    void tryPartitions(const Regions<1, 4>& whole) {
        const Bc7Plane<D> plane(texels_, whole, product_, kIterations);
        const Bc7PartitionRanking<D> partitions(texels_, plane.p, plane.q, kQuantization);
        Bc7Ranking<D> two(search_.twoRegions);
        partitions.rankTwo(64, two);
        const bool anyOpaque = !hn::AllFalse(D(), texels_.opaque), anyAlpha = !hn::AllFalse(D(), texels_.hasAlpha);
        const F product3[6] = {product_[0], product_[1], product_[2], product_[4], product_[5], product_[7]};
        for (int i = 0; i < two.keep; ++i) {
            if (anyOpaque) {
                Regions<2, 3> regions(texels_, kColours, two.choice[i]);
                regions.start(product3, kIterations);
                keep(regions, 1, texels_.opaque, two.choice[i]);
                keep(regions, 3, texels_.opaque, two.choice[i]);
            }
            if (anyAlpha) {
                Regions<2, 4> regions(texels_, kAll, two.choice[i]);
                regions.start(product_, kIterations);
                keep(regions, 7, texels_.hasAlpha, two.choice[i]);
            }
        }
        if (search_.threeRegions == 0 || !anyOpaque) return;
        // Mode 0 has only the first sixteen partitions, so these are ranked separately.
        Bc7Ranking<D> three(search_.threeRegions), first16(std::min(search_.threeRegions, 16));
        partitions.rankThree(three, first16);
        const auto tryThree = [&](int mode, I number) {
            I second, third;
            masksOf(number, second, third);
            Regions<3, 3> regions(texels_, kColours, second, third);
            regions.start(product3, kIterations);
            keep(regions, mode, texels_.opaque, number);
        };
        for (int i = 0; i < first16.keep; ++i) tryThree(0, first16.choice[i]);
        for (int i = 0; i < three.keep; ++i) tryThree(2, three.choice[i]);
    }
    /// Returns the texels of regions 1 and 2 of the partition of each lane, as Bc7RegionFit wants them.
    static void masksOf(I number, I& second, I& third) {
        HWY_ALIGN std::int32_t numbers[hn::MaxLanes(D())], seconds[hn::MaxLanes(D())], thirds[hn::MaxLanes(D())];
        hn::Store(number, DI(), numbers);
        for (std::size_t lane = 0; lane < hn::Lanes(D()); ++lane) {
            const auto p = static_cast<std::size_t>(numbers[lane]);
            seconds[lane] = static_cast<std::int32_t>(std::uint32_t{kThreeRegionsMask[0][p]} << 16);
            thirds[lane] = kThreeRegionsMask[1][p];
        }
        second = hn::Load(DI(), seconds);
        third = hn::Load(DI(), thirds);
    }
    template <int kRegions, int kChannels>
    void keep(const Regions<kRegions, kChannels>& regions, int mode, M allowed, I choice) {
        const Bc7Mode& m = kBc7Modes[static_cast<std::size_t>(mode)];
        Ends ends[kRegions];
        F error = regions.fit(mode, m.colourBits, m.indexBits, search_.refits, ends);
        if (kChannels == 3) error = error + texels_.opaqueError;
        const I partition = hn::And(choice, hn::Set(DI(), 63));
        insert(allowed, error, hn::Or(hn::ShiftLeft<Bc7Candidate::kPartitionShift>(partition), hn::Set(DI(), Bc7Candidate{mode}.number())));
    }

    const Bc7Search& search_;
    Bc7ScaledTexels<D> texels_;
    F product_[10];  ///< see Bc7ScaledTexels::products
    F error_[Bc7Search::kMostPolished];
    I number_[Bc7Search::kMostPolished];
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
