// The full BC6H search, one block in each lane.
//
// Method, with the counts given by Bc6hSearch:
// 1. One region: fit a line in v (lines-inl.h), choose the finest mode whose deltas hold its ends (codes-inl.h), choose among ends beyond
//    the texels (subranges-inl.h), round, choose indices, measure the exact error in the metric. Then alternate: refit the line to the
//    chosen indices, weighted by the measured cost of each miss, and round again. Optionally try all other modes with the last line.
// 2. Two regions: rank the 32 partitions by an estimate from their moments (partitions-inl.h) and do the same for the best ones.
// 3. Coordinate descent on the integer codes of the best candidate: single steps of each code, optionally of both ends of a channel, judged
//    by the exact error. At high effort the candidates of the best partitions are descended before they are compared.
// 4. Fall back to one colour if it beats every line fit, as for isolated bright texels on black.
#if defined(LIGHTCOOK_COMPRESS_BC6H_FIT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC6H_FIT_INL_H_
#undef LIGHTCOOK_COMPRESS_BC6H_FIT_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC6H_FIT_INL_H_
#endif

#include <hwy/highway.h>

#include <cstring>
#include <type_traits>

#include "compress/bc6h/codes-inl.h"
#include "compress/bc6h/lines-inl.h"
#include "compress/bc6h/one_colour-inl.h"
#include "compress/bc6h/partitions-inl.h"
#include "compress/block/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D, bool kSigned>
class Bc6hFit : Lanes<D> {
    using typename Lanes<D>::F, typename Lanes<D>::M, typename Lanes<D>::DI, typename Lanes<D>::I;
    using Lanes<D>::set, Lanes<D>::zero, Lanes<D>::clamp, Lanes<D>::select;
    using Codes = Bc6hCodes<D, kSigned>;
    using Line = Bc6hLine<D>;
    using OneColour = Bc6hOneColour<D, kSigned>;
    using ModeLanes = typename Codes::ModeLanes;
    using OneRegion = Bc6hOneRegion<D>;
    using TwoRegions = Bc6hTwoRegions<D>;
    using Texels = F[kTexelCount];

public:
    Bc6hFit(const Bc6hSearch& search, const EncodeOptions& options) : search_(search), lines_(search, options) {}

    /// Encodes Lanes(d) blocks. Results go to found, one after the other.
    void run(const Block* const* blocks, Bc6hResult* found) {
        lines_.load(blocks);
        clearBest();
        if (lines_.raiseStart()) {
            tryRegions(OneRegion(), hn::Zero(DI()), false);
            lines_.restoreStart();
        }
        tryRegions(OneRegion(), hn::Zero(DI()), search_.everyMode > 0);
        if (search_.partitions > 0) tryTwoRegions();
        descend();
        tryOneColour();
        store(found);
    }

private:
    /// Moves of coordinate descent: steps of the codes of the first and the second end of a channel. The last four need Bc6hSearch::pairs.
    static constexpr int kMoves[8][2] = {{-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, 1}, {-1, 1}, {1, -1}};

    struct Candidate {
        F error;
        I mode, partition;
        F code[4][3];
        F index[kTexelCount];
    };

    void clearBest() {
        best_.error = set(1e30f);
        best_.mode = best_.partition = hn::Zero(DI());
        for (auto& end : best_.code)
            for (F& code : end) code = zero();
        for (F& index : best_.index) index = zero();
    }

    /// Evaluates codes and keeps them where they beat the best so far. index receives the indices of the texels.
    /// Reweigh: std::true_type updates the weights for a refit that follows
    template <class Regions, class Reweigh>
    F tryCodes(const Regions& regions, I partition, const ModeLanes& mode, F (*code)[3], Texels& index, Reweigh reweigh) {
        Line whole[2];
        Codes::linesOf(regions, code, mode, whole);
        lines_.chooseIndices(regions, whole, index);
        const F error = lines_.errorOf(regions, whole, index, reweigh);
        keepWhere<Regions>(error < best_.error, error, partition, mode, code, index);
        return error;
    }

    template <class Regions>
    void keepWhere(M better, F error, I partition, const ModeLanes& mode, const F (*code)[3], const Texels& index) {
        if (hn::AllFalse(D(), better)) return;
        const auto betterI = hn::RebindMask(DI(), better);
        best_.error = select(better, error, best_.error);
        best_.mode = hn::IfThenElse(betterI, mode.index, best_.mode);
        best_.partition = hn::IfThenElse(betterI, partition, best_.partition);
        for (int e = 0; e < 2 * Regions::kCount; ++e)
            for (int c = 0; c < 3; ++c) best_.code[e][c] = select(better, code[e][c], best_.code[e][c]);
        for (int t = 0; t < kTexelCount; ++t) best_.index[t] = select(better, index[t], best_.index[t]);
    }

    /// Fits lines in these regions, chooses the mode, and refits the lines to the indices that the rounded ends lead to.
    template <class Regions>
    void tryRegions(const Regions& regions, I partition, bool everyMode) {
        Texels index;
        Line lines[2], usual[2];
        lines_.start(regions, lines);
        for (int i = 0; i < search_.freeRefits; ++i) lines_.refitFree(regions, index, lines);
        lines_.orient(regions, lines);
        const ModeLanes mode = Codes::finestMode(regions, lines);
        if (const int subranges = search_.subranges[Regions::kCount - 1]; subranges > 0) {
            if (search_.bothStarts) {
                std::memcpy(usual, lines, sizeof(usual));
                tryAndRefit(regions, partition, mode, usual);
                lines_.resetWeights();
            }
            lines_.chooseSubranges(regions, mode, subranges, lines);
            lines_.orient(regions, lines);
        }
        tryAndRefit(regions, partition, mode, lines);
        if (!everyMode) return;
        // A finer mode with a clamped delta, or a coarser one whose codes happen to fit better, may win.
        constexpr int kPlaces[] = {1, 2, 3, -1, 4, 5, 6, 7, 8};  // in modesByPrecision(), from the chosen mode: finer ones gain most
        const int count = std::min(search_.otherModes, Regions::kCount == 1 ? 3 : 9);
        F code[4][3];
        for (int i = 0; i < count; ++i) {
            const ModeLanes other = Codes::modeBeside(regions, mode, kPlaces[i]);
            Codes::codesOf(regions, lines, other, code);
            Codes::clampDeltas(regions, other, code);
            tryCodes(regions, partition, other, code, index, std::false_type());
        }
    }

    /// Rounds the ends of lines to codes of a mode, and refits the lines to the indices that the codes lead to. Keeps the best codes.
    template <class Regions>
    void tryAndRefit(const Regions& regions, I partition, const ModeLanes& mode, Line* lines) {
        Texels index;
        F code[4][3];
        Codes::codesOf(regions, lines, mode, code);
        Codes::clampDeltas(regions, mode, code);
        for (int i = 0; i < search_.codedRefits; ++i) {
            tryCodes(regions, partition, mode, code, index, std::true_type());
            lines_.refit(regions, index, lines);
            Codes::codesOf(regions, lines, mode, code);
            Codes::clampDeltas(regions, mode, code);
        }
        tryCodes(regions, partition, mode, code, index, std::false_type());
    }

    /// Falls back to one colour, in the 16-bit mode, if it beats every line fit, as for isolated bright texels on black.
    void tryOneColour() {
        F mean[3], code[4][3];
        const M worse = OneColour::errorOf(lines_.texels(), mean) < best_.error;
        if (hn::AllFalse(D(), worse)) return;
        for (int c = 0; c < 3; ++c) code[0][c] = code[1][c] = OneColour::wholeVOf(lines_.texels().values(), mean[c]);
        const ModeLanes mode = Codes::modeLanes(kBc6h16BitMode);
        const OneRegion regions;
        Line whole[2];
        Texels index;
        Codes::linesOf(regions, code, mode, whole);
        for (F& i : index) i = zero();
        const F error = lines_.errorOf(regions, whole, index, std::false_type());
        keepWhere<OneRegion>(hn::And(worse, error < best_.error), error, hn::Zero(DI()), mode, code, index);
    }

    void tryTwoRegions() {
        using Partitions = Bc6hPartitions<D>;
        const int keep = std::min(search_.partitions, Partitions::kMost);
        I kept[Partitions::kMost];
        Partitions::rank(lines_.texels().estimate, lines_.texels().estimateWeight, keep, kept);
        for (int i = 0; i < keep; ++i) {
            if (i >= search_.everyMode && i < search_.triedPartitions) continue;
            const TwoRegions regions(kept[i]);
            if (i >= search_.polished) {
                tryRegions(regions, kept[i], i < search_.everyMode);
                continue;
            }
            // Descend the best candidate of this partition before it is compared with the others.
            const Candidate others = best_;
            clearBest();
            tryRegions(regions, kept[i], i < search_.everyMode);
            for (int pass = 0; pass < search_.descents; ++pass)
                if (!descendOnce(regions)) break;
            keepBetterOf(others);
        }
    }

    void keepBetterOf(const Candidate& others) {
        const M better = others.error < best_.error;
        const auto betterI = hn::RebindMask(DI(), better);
        best_.error = select(better, others.error, best_.error);
        best_.mode = hn::IfThenElse(betterI, others.mode, best_.mode);
        best_.partition = hn::IfThenElse(betterI, others.partition, best_.partition);
        for (int e = 0; e < 4; ++e)
            for (int c = 0; c < 3; ++c) best_.code[e][c] = select(better, others.code[e][c], best_.code[e][c]);
        for (int t = 0; t < kTexelCount; ++t) best_.index[t] = select(better, others.index[t], best_.index[t]);
    }

    /// Returns the mode of each lane's best candidate. mask receives the lanes whose mode has this number of regions.
    template <class Regions>
    ModeLanes bestMode(const Regions&, M& mask) const {
        constexpr int kFirst = Regions::kCount == 1 ? 10 : 0, kEnd = Regions::kCount == 1 ? 14 : 10;  // in kBc6hModes
        ModeLanes mode = Codes::modeLanes(kFirst);
        mask = hn::RebindMask(D(), best_.mode == hn::Set(DI(), kFirst));
        for (int m = kFirst + 1; m < kEnd; ++m) {
            const M here = hn::RebindMask(D(), best_.mode == hn::Set(DI(), m));
            Codes::overrideWhere(here, Codes::modeLanes(m), mode);
            mask = hn::Or(mask, here);
        }
        return mode;
    }

    /// Runs coordinate descent from the best candidate until no lane improves.
    void descend() {
        for (int pass = 0; pass < search_.descents; ++pass) {
            const bool one = descendOnce(OneRegion());
            const bool two = search_.partitions > 0 && descendOnce(TwoRegions(best_.partition));
            if (!one && !two) return;
        }
    }

    /// Returns true if descent tries only the moves that the model ranks best. The model is quadratic in v, but the metric has a kink at 0:
    /// for light of both signs, the deeper searches try all moves (up to 0.08 dB on SH bands).
    bool ranksMoves() const { return search_.moves > 0 && !(kSigned && search_.polished > 0); }

    template <class Regions>
    bool descendOnce(const Regions& regions) {
        M mask;
        const ModeLanes mode = bestMode(regions, mask);
        if (hn::AllFalse(D(), mask)) return false;
        if (ranksMoves()) {  // by the cost of the misses of the best candidate
            Line whole[2];
            Codes::linesOf(regions, best_.code, mode, whole);
            lines_.errorOf(regions, whole, best_.index, std::true_type());
        }
        bool improved = false;
        for (int r = 0; r < Regions::kCount; ++r)
            for (int c = 0; c < 3; ++c) {
                if (ranksMoves()) {
                    improved |= tryBestMoves(regions, mode, mask, r, c);
                    continue;
                }
                for (int move = 0; move < (search_.pairs ? 8 : 4); ++move)
                    improved |=
                        step(regions, mode, mask, r, c, set(static_cast<float>(kMoves[move][0])), set(static_cast<float>(kMoves[move][1])));
            }
        return improved;
    }

    /// Tries the `moves` moves of the ends of a channel with the least error in a quadratic model (ChannelModel), in each lane its own.
    template <class Regions>
    bool tryBestMoves(const Regions& regions, const ModeLanes& mode, M mask, int r, int c) {
        constexpr int kMostMoves = 8;
        F value[2][3];  // of the ends, a step below to a step above
        Line line;
        for (int e = 0; e < 2; ++e)
            for (int i = 0; i < 3; ++i) {
                const F low = kSigned ? zero() - mode.largestCode : zero();
                value[e][i] = Codes::valueOf(clamp(best_.code[2 * r + e][c] + set(static_cast<float>(i - 1)), low, mode.largestCode), mode);
            }
        for (int other = 0; other < 3; ++other) {
            line.a[other] = Codes::valueOf(best_.code[2 * r][other], mode);
            line.d[other] = Codes::valueOf(best_.code[2 * r + 1][other], mode) - line.a[other];
        }
        const typename Bc6hLines<D, kSigned>::template ChannelModel<Regions> model(lines_, regions, r, c, line);
        const F now = model.errorOf(value[0][1], value[1][1]);
        F score[kMostMoves], first[kMostMoves], second[kMostMoves];
        for (int i = 0; i < search_.moves; ++i) score[i] = set(1e30f), first[i] = second[i] = zero();
        for (int move = 0; move < (search_.pairs ? 8 : 4); ++move) {
            F m0 = set(static_cast<float>(kMoves[move][0])), m1 = set(static_cast<float>(kMoves[move][1]));
            F change = model.errorOf(value[0][kMoves[move][0] + 1], value[1][kMoves[move][1] + 1]) - now;
            change = select(deltasFitAfter<Regions>(mode, r, c, m0, m1), change, set(1e30f));
            for (int i = 0; i < search_.moves; ++i) {  // insertion sort: the displaced entry moves on
                const M better = change < score[i];
                const F lost = select(better, score[i], change), lost0 = select(better, first[i], m0),
                        lost1 = select(better, second[i], m1);
                score[i] = select(better, change, score[i]);
                first[i] = select(better, m0, first[i]);
                second[i] = select(better, m1, second[i]);
                change = lost, m0 = lost0, m1 = lost1;
            }
        }
        bool improved = false;
        for (int i = 0; i < search_.moves; ++i) {
            const M possible = hn::And(mask, score[i] < set(1e30f));
            if (hn::AllFalse(D(), possible)) break;
            improved |= step(regions, mode, mask, r, c, first[i], second[i]);
        }
        return improved;
    }

    /// Returns the lanes in which the mode can store the deltas of channel c after a move of the ends of region r.
    template <class Regions>
    M deltasFitAfter(const ModeLanes& mode, int r, int c, F first, F second) const {
        const F base = r == 0 ? best_.code[0][c] + first : best_.code[0][c];
        M fits = zero() == zero();
        for (int e = 1; e < 2 * Regions::kCount; ++e) {
            const F code = e == 2 * r ? best_.code[e][c] + first : e == 2 * r + 1 ? best_.code[e][c] + second : best_.code[e][c];
            const F delta = code - base;
            fits = hn::And(fits, hn::And(delta >= zero() - mode.deltaLimit[c], delta < mode.deltaLimit[c]));
        }
        return fits;
    }

    /// Moves two codes of the best candidate and keeps the result where it is better. Returns false if no lane improved.
    template <class Regions>
    bool step(const Regions& regions, const ModeLanes& mode, M mask, int r, int c, F first, F second) {
        F code[4][3];
        std::memcpy(code, best_.code, sizeof(code));
        const F low = kSigned ? zero() - mode.largestCode : zero();
        code[2 * r][c] = clamp(code[2 * r][c] + first, low, mode.largestCode);
        code[2 * r + 1][c] = clamp(code[2 * r + 1][c] + second, low, mode.largestCode);
        Line whole[2];
        Texels index;
        Codes::linesOf(regions, code, mode, whole);
        lines_.chooseIndices(regions, whole, index);
        const F error = lines_.errorOf(regions, whole, index, std::false_type());
        const M better = hn::And(hn::And(mask, Codes::deltasFit(regions, code, mode)), error < best_.error);
        keepWhere<Regions>(better, error, best_.partition, mode, code, index);
        return !hn::AllFalse(D(), better);
    }

    void store(Bc6hResult* found) const {
        const D d;
        const DI di;
        HWY_ALIGN std::int32_t buffer[hn::MaxLanes(D())];
        const std::size_t lanes = hn::Lanes(d);
        const auto each = [&](I value, auto assign) {
            hn::Store(value, di, buffer);
            for (std::size_t lane = 0; lane < lanes; ++lane) assign(found[lane], buffer[lane]);
        };
        each(best_.mode, [](Bc6hResult& r, std::int32_t v) { r.mode = v; });
        each(best_.partition, [](Bc6hResult& r, std::int32_t v) { r.partition = v; });
        for (std::size_t e = 0; e < 4; ++e)
            for (std::size_t c = 0; c < 3; ++c)
                each(hn::ConvertTo(di, best_.code[e][c]), [e, c](Bc6hResult& r, std::int32_t v) { r.code[e][c] = v; });
        for (std::size_t t = 0; t < kTexelCount; ++t)
            each(hn::ConvertTo(di, best_.index[t]), [t](Bc6hResult& r, std::int32_t v) { r.index[t] = static_cast<std::uint8_t>(v); });
        HWY_ALIGN float error[hn::MaxLanes(D())];
        hn::Store(best_.error, d, error);
        for (std::size_t lane = 0; lane < lanes; ++lane) found[lane].error = error[lane];
    }

    const Bc6hSearch& search_;
    Bc6hLines<D, kSigned> lines_;
    Candidate best_;
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
