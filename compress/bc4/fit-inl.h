// The kernel of BC4, BC5 and BC3's alpha: one channel, one block in each lane.
//
// Method:
// 1. Eight-value mode: local search (ends-inl.h) from several starts between the smallest and the largest value of the block.
// 2. Six-value mode: the same, with the error of each texel also compared with the two exact extremes, code 0 and the largest code. Some
//    blocks are better if the texels near the extremes take these two, and the six equidistant entries are fitted to the rest only: for
//    each of several thresholds (kBc4Thresholds), texels that are nearer to an extreme are left out of the fit. This second part is skipped
//    for a block where it cannot win: a texel that takes an extreme must alone cause less error than the whole block in the eight-value
//    mode.
// 3. A block of one value gets two neighbouring codes, whose palette contains sevenths and fifths of a code.
#if defined(LIGHTCOOK_COMPRESS_BC4_FIT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC4_FIT_INL_H_
#undef LIGHTCOOK_COMPRESS_BC4_FIT_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC4_FIT_INL_H_
#endif

#include <hwy/highway.h>

#include "compress/bc4/ends-inl.h"
#include "compress/bc4/pack-inl.h"
#include "compress/bc4/search.h"
#include "compress/bc4/texels-inl.h"
#include "compress/block/block.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D>
class Bc4Fit : Lanes<D> {
    using typename Lanes<D>::F, typename Lanes<D>::M, typename Lanes<D>::U;
    using Lanes<D>::set;
    using Candidate = Bc4Candidate<D>;
    using EndSearch = Bc4EndSearch<D>;

public:
    explicit Bc4Fit(const Bc4Search& search, const Bc4Codes& codes = kBc4Unorm) : search_(search), texels_(codes) {}

    /// Encodes one channel of Lanes(d) blocks.
    void run(const Block* const* blocks, std::size_t channel, Bc4Result* found) {
        texels_.load(blocks, channel);
        M isSix;
        const Candidate best = search(isSix);
        Bc4Packer<D>(texels_, best, isSix).store(found);
    }

    /// Encodes blocks that are in lanes already.
    /// value, weight  in the range of the format; at least one weight above 0 in each lane
    /// weightsAreOne  all weights are known to be 1
    /// Returns the low and the high word of each block.
    void run(const F (&value)[kTexelCount], const F (&weight)[kTexelCount], bool weightsAreOne, U& lowWord, U& highWord) {
        texels_.load(value, weight, weightsAreOne);
        M isSix;
        const Candidate best = search(isSix);
        Bc4Packer<D>(texels_, best, isSix).pack(lowWord, highWord);
    }

private:
    Candidate search(M& isSix) {
        Candidate eight = texels_.nothing(), six = texels_.nothing();
        const M isConstant = texels_.lowest >= texels_.highest;
        const bool someConstant = !hn::AllFalse(D(), isConstant);
        if (search_.sixValues || someConstant) texels_.measureExtremes();
        if (someConstant) {
            fitConstant<false>(isConstant, eight);
            fitConstant<true>(isConstant, six);
        }
        const Candidate constant = eight;
        const EndSearch ends(search_, texels_);
        ends.template fitBetween<false>(texels_.weight, texels_.all, texels_.lowest, texels_.highest, search_.starts, eight);
        if (!search_.sixValues) {
            isSix = hn::And(isConstant, six.error < constant.error);
            return Candidate::choose(isSix, six, Candidate::choose(isConstant, constant, eight));
        }
        fitSix(ends, eight.error, six);
        isSix = six.error < eight.error;
        return Candidate::choose(isSix, six, eight);
    }

    /// Sets the candidate of lanes with a single value: codes side by side, whose palette contains every seventh or fifth of a code.
    template <bool kSix>
    void fitConstant(M isConstant, Candidate& best) const {
        constexpr float kSteps = Bc4Texels<D>::template steps<kSix>();
        const F low = hn::Min(hn::Floor(hn::Round(texels_.lowest * set(kSteps)) / set(kSteps)), texels_.largest() - set(1.0f));
        const F error = texels_.template errorOf<kSix>(low, low + set(1.0f));
        best = Candidate::choose(isConstant, {error, low, low + set(1.0f)}, best);
    }

    /// Searches the six-value mode. A lane uses the search near the extremes only if one of its own texels can profit, so the result does
    /// not depend on the blocks in other lanes.
    void fitSix(const EndSearch& ends, F errorOfEight, Candidate& best) const {
        Candidate found = texels_.nothing();
        ends.template fitBetween<true>(texels_.weight, texels_.all, texels_.lowest, texels_.highest, search_.plainStarts, found);
        const M hasExtremes = texels_.leastNear < errorOfEight;
        if (!hn::AllFalse(D(), hasExtremes)) {
            const Candidate plain = found;
            for (int i = 0; i < search_.thresholds; ++i) fitAway(ends, kBc4Thresholds[static_cast<std::size_t>(i)], found);
            found = Candidate::choose(hasExtremes, found, plain);
        }
        if (!search_.polishEach) ends.template polish<true>(found);
        best = Candidate::choose(found.error < best.error, found, best);
    }

    /// Fits the six equidistant entries to the texels that are at least `near` codes away from both extremes. The others keep their
    /// distance from the extremes as a constant error.
    void fitAway(const EndSearch& ends, float near, Candidate& found) const {
        F from, to, weight[kTexelCount];
        rangeAway(near, from, to);
        for (std::size_t t = 0; t < kTexelCount; ++t)
            weight[t] = hn::IfThenElseZero(hn::And(texels_.value[t] >= from, texels_.value[t] <= to), texels_.weight[t]);
        auto moments = texels_.momentsOf(weight);
        for (std::size_t t = 0; t < kTexelCount; ++t)
            moments.left = hn::MulAdd((texels_.weight[t] - weight[t]) * texels_.nearEnd[t], texels_.nearEnd[t], moments.left);
        ends.template fitBetween<true>(weight, moments, from, to, search_.thresholdStarts, found);
    }

    /// Returns the range of the significant texels that are at least `near` codes away from both extremes, or of all if there are none.
    HWY_INLINE void rangeAway(float near, F& from, F& to) const {
        F low = texels_.largest(), high = set(0.0f);
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            const F value = texels_.value[t];
            const M counts = texels_.weight[t] > set(0.0f);
            const M offZero = hn::And(counts, value >= set(near)), offLargest = hn::And(counts, value <= texels_.largest() - set(near));
            low = hn::IfThenElse(offZero, hn::Min(low, value), low);
            high = hn::IfThenElse(offLargest, hn::Max(high, value), high);
        }
        const M some = low <= high;
        from = hn::IfThenElse(some, low, texels_.lowest);
        to = hn::IfThenElse(some, high, texels_.highest);
    }

    const Bc4Search& search_;
    Bc4Texels<D> texels_;
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
