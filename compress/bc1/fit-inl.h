// The kernel of BC1 and of BC3's colour, one block in each lane.
//
// Method, for the four-colour mode and, in BC1, the three-colour mode:
// 1. Starts: texels are projected onto the principal axis of the block, and each start (kBc1Starts) divides a part of their range into
//    equal steps. The least-squares endpoints of that assignment and their rounding to codes have closed forms (texels-inl.h), so a start
//    costs one pass over the texels. Another start is the mean colour, one step from the first endpoint: best for nearly constant blocks.
// 2. The best of each group of starts is refined: assign every texel to its nearest palette entry, solve and round again.
// 3. Coordinate descent on the integer endpoint codes: single steps of each code, at higher effort also of both codes of a channel, for as
//    long as the error falls.
// The best candidate of all groups and both modes wins. A block of one colour takes the mean colour, which has the least possible error.
#if defined(LIGHTCOOK_COMPRESS_BC1_FIT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC1_FIT_INL_H_
#undef LIGHTCOOK_COMPRESS_BC1_FIT_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC1_FIT_INL_H_
#endif

#include <hwy/highway.h>

#include <algorithm>

#include "compress/bc1/pack-inl.h"
#include "compress/bc1/search.h"
#include "compress/bc1/texels-inl.h"
#include "compress/block/block.h"
#include "compress/block/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D>
class Bc1Fit : Lanes<D> {
    using typename Lanes<D>::F, typename Lanes<D>::M, typename Lanes<D>::U;
    using Lanes<D>::set, Lanes<D>::zero, Lanes<D>::clamp;
    using Candidate = Bc1Candidate<D>;
    using Line = Bc1Line<D>;

public:
    Bc1Fit(const Bc1Search& search, const EncodeOptions& options, bool mayUseThree)
        : search_(search), mayUseThree_(mayUseThree), texels_(options) {}

    Bc1Texels<D>& texels() { return texels_; }

    /// Encodes Lanes(d) blocks.
    void run(const Block* const* blocks, Bc1Result* found) {
        texels_.load(blocks);
        M isThree;
        const Candidate best = search(isThree);
        Bc1Packer<D>(texels_, best, isThree, mayUseThree_).store(found);
    }

    /// Encodes the blocks that texels() holds. Returns the two words of each block.
    void run(U& ends, U& indices) {
        M isThree;
        const Candidate best = search(isThree);
        Bc1Packer<D>(texels_, best, isThree, mayUseThree_).pack(ends, indices);
    }

private:
    Candidate search(M& isThree) {
        texels_.project(search_.axisSteps, along_, low_, high_);
        Candidate best = fit<3>();
        isThree = zero() != zero();
        if (!mayUseThree_) return best;
        const M isConstant = texels_.isConstant();
        if (search_.threeColours) {
            const Candidate three = fit<2>();
            isThree = three.error < best.error;
            best = Candidate::choose(isThree, three, best);
        } else if (!hn::AllFalse(D(), isConstant)) {
            const Candidate three = texels_.template oneColour<2>();
            isThree = hn::And(isConstant, three.error < best.error);
            best = Candidate::choose(isThree, three, best);
        }
        return best;
    }

    /// Searches the mode of kSteps + 1 colours.
    template <int kSteps>
    Candidate fit() const {
        const Candidate oneColour = texels_.template oneColour<kSteps>();
        Candidate best = oneColour;
        const F range = high_ - low_;
        for (int start = 0; start < search_.starts;) {
            Candidate candidate = oneColour;
            if (start > 0) candidate.error = set(1e30f);
            for (const int end = std::min(start + search_.startsPerDescent, search_.starts); start < end; ++start) {
                const auto& moved = kBc1Starts[static_cast<std::size_t>(start)];
                const Line line = texels_.template lineOf<kSteps>(along_, hn::MulAdd(range, set(moved[0]), low_),
                                                                  hn::NegMulAdd(range, set(moved[1]), high_));
                const Candidate trial = texels_.rounded(line);
                candidate = Candidate::choose(trial.error < candidate.error, trial, candidate);
            }
            for (int i = 0; i < search_.refits; ++i) refit<kSteps>(candidate);
            if (search_.passes > 0) candidate.error = texels_.template errorOf<kSteps>(candidate);
            for (int pass = 0; pass < search_.passes; ++pass)
                if (!descend<kSteps>(candidate)) break;
            best = Candidate::choose(candidate.error < best.error, candidate, best);
        }
        return Candidate::choose(texels_.isConstant(), oneColour, best);
    }

    /// Assigns the texels to the palette of a candidate, and keeps the best codes for this assignment where they are better.
    template <int kSteps>
    HWY_INLINE void refit(Candidate& best) const {
        const Line line = texels_.template lineOf<kSteps>(best);
        best.error = texels_.errorOf(line, best);
        const Candidate trial = texels_.rounded(line);
        best = Candidate::choose(trial.error < best.error, trial, best);
    }

    /// Runs one pass of coordinate descent. Returns false if no lane improved.
    template <int kSteps>
    bool descend(Candidate& best) const {
        constexpr float kMoves[8][2] = {{-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, 1}, {-1, 1}, {1, -1}};
        bool improved = false;
        for (int c = 0; c < 3; ++c)
            for (int move = 0; move < (search_.diagonals ? 8 : 4); ++move) {
                Candidate trial = best;
                const F most = set(Bc1Texels<D>::largestCode(c));
                for (int e = 0; e < 2; ++e) trial.code[e][c] = clamp(trial.code[e][c] + set(kMoves[move][e]), zero(), most);
                trial.error = texels_.template errorOf<kSteps>(trial);
                const M better = trial.error < best.error;
                improved |= !hn::AllFalse(D(), better);
                best = Candidate::choose(better, trial, best);
            }
        return improved;
    }

    const Bc1Search& search_;
    bool mayUseThree_;
    Bc1Texels<D> texels_;
    F along_[kTexelCount], low_, high_;  ///< places on the principal axis, and their range
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
