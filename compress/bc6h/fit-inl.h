// The full BC6H search, one block in each lane.
//
// Method, with the counts given by Bc6hSearch:
// 1. One region: fit a line in v (lines-inl.h), choose the finest mode whose deltas hold its ends (codes-inl.h), round, choose indices,
//    measure the exact error in the metric. Then alternate: refit the line to the chosen indices, weighted by the measured cost of each
//    miss, and round again. Optionally try all other modes with the last line.
// 2. Two regions: rank the 32 partitions by an estimate from their moments (partitions-inl.h) and do the same for the best ones.
// 3. Coordinate descent on the integer codes of the best candidate: single steps of each code, optionally of both ends of a channel, judged
//    by the exact error. At high effort each of the best partitions is descended before they are compared.
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
        tryRegions(OneRegion(), hn::Zero(DI()), search_.everyMode > 0);
        if (search_.partitions > 0) tryTwoRegions();
        descend();
        tryOneColour();
        store(found);
    }

private:
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
    template <class Regions>
    F tryCodes(const Regions& regions, I partition, const ModeLanes& mode, F (*code)[3], Texels& index) {
        Line whole[2];
        Codes::linesOf(regions, code, mode, whole);
        lines_.chooseIndices(regions, whole, index);
        const F error = lines_.errorOf(regions, whole, index, std::true_type());
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
        Line lines[2];
        lines_.start(regions, lines);
        for (int i = 0; i < search_.freeRefits; ++i) lines_.refitFree(regions, index, lines);
        lines_.orient(regions, lines);
        const ModeLanes mode = Codes::finestMode(regions, lines);
        F code[4][3];
        Codes::codesOf(regions, lines, mode, code);
        Codes::clampDeltas(regions, mode, code);
        tryCodes(regions, partition, mode, code, index);
        for (int i = 0; i < search_.codedRefits; ++i) {
            lines_.refit(regions, index, lines);
            Codes::codesOf(regions, lines, mode, code);
            Codes::clampDeltas(regions, mode, code);
            tryCodes(regions, partition, mode, code, index);
        }
        if (!everyMode) return;
        // A finer mode with a clamped delta, or a coarser one whose codes happen to fit better, may win.
        for (int m = Regions::kCount == 1 ? 10 : 0; m < (Regions::kCount == 1 ? 14 : 10); ++m) {
            const ModeLanes other = Codes::modeLanes(m);
            Codes::codesOf(regions, lines, other, code);
            Codes::clampDeltas(regions, other, code);
            tryCodes(regions, partition, other, code, index);
        }
    }

    /// Falls back to one colour, in the 16-bit mode, if it beats every line fit, as for isolated bright texels on black.
    void tryOneColour() {
        F mean[3], code[4][3];
        const M worse = OneColour::errorOf(lines_.texels(), mean) < best_.error;
        if (hn::AllFalse(D(), worse)) return;
        for (int c = 0; c < 3; ++c) code[0][c] = code[1][c] = OneColour::wholeVOf(lines_.texels().values(), mean[c]);
        const ModeLanes mode = Codes::modeLanes(13);
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
        constexpr int kFirst = Regions::kCount == 1 ? 10 : 0, kEnd = Regions::kCount == 1 ? 14 : 10;
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

    template <class Regions>
    bool descendOnce(const Regions& regions) {
        M mask;
        const ModeLanes mode = bestMode(regions, mask);
        if (hn::AllFalse(D(), mask)) return false;
        // Steps of the first and the second end of a region.
        constexpr float kMoves[8][2] = {{-1, 0}, {1, 0}, {0, -1}, {0, 1}, {-1, -1}, {1, 1}, {-1, 1}, {1, -1}};
        bool improved = false;
        for (int r = 0; r < Regions::kCount; ++r)
            for (int c = 0; c < 3; ++c)
                for (int move = 0; move < (search_.pairs ? 8 : 4); ++move)
                    improved |= step(regions, mode, mask, r, c, kMoves[move][0], kMoves[move][1]);
        return improved;
    }

    /// Moves two codes of the best candidate and keeps the result where it is better. Returns false if no lane improved.
    template <class Regions>
    bool step(const Regions& regions, const ModeLanes& mode, M mask, int r, int c, float first, float second) {
        F code[4][3];
        std::memcpy(code, best_.code, sizeof(code));
        const F low = kSigned ? zero() - mode.largestCode : zero();
        code[2 * r][c] = clamp(code[2 * r][c] + set(first), low, mode.largestCode);
        code[2 * r + 1][c] = clamp(code[2 * r + 1][c] + set(second), low, mode.largestCode);
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
