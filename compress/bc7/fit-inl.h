// The BC7 kernel, one block in each lane. Values are in 0 .. 255.
//
// Method, with the counts given by Bc7Search. Modes are tried in this order, and the least error wins:
// 1. Mode 6: one line in four channels.
// 2. Modes 5 and 4: one line for three channels, and a separate one for the fourth, which may be any channel (rotation).
// 3. Modes 1 and 3 (opaque blocks) and 7 (others): two regions. Partitions are ranked by an estimate from their moments
//    (partitions-inl.h) and the best ones are fitted.
// 4. Modes 0 and 2 (opaque blocks): three regions, ranked in the same way.
// The fit of a mode: line along the principal axis, refits with unrounded ends, rounding to codes with the nearest low bits, refits to the
// indices of the rounded ends, optionally all combinations of low bits, and coordinate descent by single steps of each code.
//
// A mode is computed for all lanes if any lane may use it, but kept only in lanes that may: the result of a block does not depend on the
// blocks in other lanes.
#if defined(LIGHTCOOK_COMPRESS_BC7_FIT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC7_FIT_INL_H_
#undef LIGHTCOOK_COMPRESS_BC7_FIT_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC7_FIT_INL_H_
#endif

#include <hwy/highway.h>

#include <algorithm>

#include "compress/bc7/codes-inl.h"
#include "compress/bc7/lines-inl.h"
#include "compress/bc7/partitions-inl.h"
#include "compress/bc7/search.h"
#include "compress/block/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D>
class Bc7Fit : Lanes<D> {
    using typename Lanes<D>::F, typename Lanes<D>::M, typename Lanes<D>::DI, typename Lanes<D>::I;
    using Lanes<D>::set, Lanes<D>::zero, Lanes<D>::clamp, Lanes<D>::select;
    using View = Bc7View<D>;
    using Line = Bc7Line<D>;
    using Regions = Bc7Regions<D>;
    using Partitions = Bc7Partitions<D>;
    using Codes = Bc7Codes<D>;
    using Coding = Bc7Coding;
    using LowBits = Bc7LowBits;
    template <int kEnds, int kChannels>
    using Coded = Bc7Coded<D, kEnds, kChannels>;
    using Texels = F[kTexelCount];

public:
    Bc7Fit(const Bc7Search& search, const EncodeOptions& options) : search_(search), options_(options) {}

    /// Encodes Lanes(d) blocks. Results go to found, one after the other.
    void run(const Block* const* blocks, Bc7Result* found) {
        load(blocks);
        clearBest();
        const Regions everything{};
        View view = rotated(0);
        tryMode<1, 4>(6, everything, hn::Zero(DI()), view);
        for (int rotation = 0; rotation < search_.rotations; ++rotation) {
            trySecondIndex(5, rotation, false);
            if (search_.mode4) {
                trySecondIndex(4, rotation, false);
                trySecondIndex(4, rotation, true);
            }
        }
        if (search_.twoRegions > 0) tryTwoRegions(view);
        if (search_.threeRegions > 0 && anyOpaque_) tryThreeRegions(view);
        store(found);
    }

private:
    struct Candidate {
        F error;
        I mode, partition, rotation, indexSelection;
        F code[6][4], low[6];
        F index[kTexelCount], second[kTexelCount];
    };

    void load(const Block* const* blocks) {
        const D d;
        const std::size_t lanes = hn::Lanes(d);
        HWY_ALIGN float buffer[hn::MaxLanes(D())];
        F total = zero(), opaqueMiss = zero();
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            for (std::size_t lane = 0; lane < lanes; ++lane) buffer[lane] = blocks[lane]->significance[t];
            lines_.significance[t] = hn::Load(d, buffer);
            for (std::size_t c = 0; c < 4; ++c) {
                for (std::size_t lane = 0; lane < lanes; ++lane) buffer[lane] = blocks[lane]->channel[c][t];
                texel_[c][t] = hn::Load(d, buffer) * set(255.0f);
            }
            const F missing = set(255.0f) - texel_[3][t];
            opaqueMiss = opaqueMiss + lines_.significance[t] * missing * missing;
            total = total + lines_.significance[t];
        }
        opaqueError_ = opaqueMiss * set(options_.channelWeights[3]);
        // Modes without alpha are worth a try in nearly opaque blocks too.
        opaque_ = opaqueError_ <= total * set(options_.channelWeights[3] * 4.0f);
        hasAlpha_ = opaqueError_ > zero();
        anyOpaque_ = !hn::AllFalse(d, opaque_);
        anyAlpha_ = !hn::AllFalse(d, hasAlpha_);
    }

    void clearBest() {
        best_.error = set(1e30f);
        best_.mode = best_.partition = best_.rotation = best_.indexSelection = hn::Zero(DI());
        for (int e = 0; e < 6; ++e) {
            best_.low[e] = zero();
            for (F& code : best_.code[e]) code = zero();
        }
        for (int t = 0; t < kTexelCount; ++t) best_.index[t] = best_.second[t] = zero();
    }

    /// Returns the channels with alpha swapped for channel rotation - 1; 0: not swapped.
    View rotated(int rotation) const {
        View view;
        for (std::size_t c = 0; c < 4; ++c) {
            const std::size_t source = rotation == 0                                 ? c
                                       : c == 3                                      ? static_cast<std::size_t>(rotation - 1)
                                       : c == static_cast<std::size_t>(rotation - 1) ? 3
                                                                                     : c;
            view.channel[c] = texel_[source];
            view.weight[c] = options_.channelWeights[source];
        }
        return view;
    }
    /// Returns the view of the separate channel alone.
    static View alone(const View& view) { return {{view.channel[3], nullptr, nullptr, nullptr}, {view.weight[3], 0, 0, 0}}; }

    /// Chooses the indices for codes, computes their error, and keeps them where they are better.
    template <int kRegions, int kChannels>
    void evaluate(const Regions& regions, const View& view, const Coding& coding, Coded<2 * kRegions, kChannels>& trial,
                  Coded<2 * kRegions, kChannels>& best) const {
        Line whole[kRegions];
        Codes::template linesOf<kRegions, kChannels>(trial, coding, whole);
        lines_.template chooseIndices<kRegions, kChannels>(regions, view, whole, coding.steps, trial.index);
        trial.error = lines_.template errorOf<kRegions, kChannels>(regions, view, whole, coding.steps, trial.index);
        const M better = trial.error < best.error;
        if (hn::AllFalse(D(), better)) return;
        best.error = select(better, trial.error, best.error);
        for (int e = 0; e < 2 * kRegions; ++e) {
            best.low[e] = select(better, trial.low[e], best.low[e]);
            for (int c = 0; c < kChannels; ++c) best.code[e][c] = select(better, trial.code[e][c], best.code[e][c]);
        }
        for (int t = 0; t < kTexelCount; ++t) best.index[t] = select(better, trial.index[t], best.index[t]);
    }

    /// Fits the lines of a mode, as the head of this file says.
    template <int kRegions, int kChannels>
    void fit(const Regions& regions, const View& view, const Coding& coding, Coded<2 * kRegions, kChannels>& best) const {
        Texels position;
        Line lines[kRegions];
        Coded<2 * kRegions, kChannels> trial;
        best.error = set(1e30f);
        lines_.template startPositions<kRegions, kChannels>(regions, view, position);
        lines_.template leastSquares<kRegions, kChannels>(regions, view, position, lines);
        for (int i = 0; i < search_.freeRefits; ++i) {
            lines_.template chooseIndices<kRegions, kChannels>(regions, view, lines, coding.steps, trial.index);
            lines_.template refit<kRegions, kChannels>(regions, view, coding.steps, trial.index, lines);
        }
        for (int i = 0; i <= search_.codedRefits; ++i) {
            if (i > 0) lines_.template refit<kRegions, kChannels>(regions, view, coding.steps, trial.index, lines);
            Codes::template codesOf<kRegions, kChannels>(view, lines, coding, -1, trial);
            evaluate<kRegions, kChannels>(regions, view, coding, trial, best);
        }
        if (search_.everyLowBit && coding.lowBits != LowBits::None) {
            lines_.template refit<kRegions, kChannels>(regions, view, coding.steps, best.index, lines);
            const int bitCount = coding.lowBits == LowBits::PerEnd ? 2 * kRegions : kRegions;
            for (int forced = 0; forced < 1 << bitCount; ++forced) {
                Codes::template codesOf<kRegions, kChannels>(view, lines, coding, forced, trial);
                evaluate<kRegions, kChannels>(regions, view, coding, trial, best);
            }
        }
        for (int pass = 0; pass < search_.descents; ++pass) descend<kRegions, kChannels>(regions, view, coding, best);
    }
    /// Runs one pass of coordinate descent.
    template <int kRegions, int kChannels>
    void descend(const Regions& regions, const View& view, const Coding& coding, Coded<2 * kRegions, kChannels>& best) const {
        const F largest = set(static_cast<float>((1 << coding.bits) - 1));
        for (int e = 0; e < 2 * kRegions; ++e)
            for (int c = 0; c < kChannels; ++c)
                for (const float step : {-1.0f, 1.0f}) {
                    Coded<2 * kRegions, kChannels> trial = best;
                    trial.code[e][c] = clamp(trial.code[e][c] + set(step), zero(), largest);
                    evaluate<kRegions, kChannels>(regions, view, coding, trial, best);
                }
    }

    /// Fits a mode with one index set.
    template <int kRegions, int kChannels>
    void tryMode(int modeIndex, const Regions& regions, I partition, const View& view) {
        Coded<2 * kRegions, kChannels> coded;
        fit<kRegions, kChannels>(regions, view, Coding::of(kBc7Modes[static_cast<std::size_t>(modeIndex)]), coded);
        const F error = kChannels == 4 ? coded.error : coded.error + opaqueError_;
        // Other lanes may have asked for this mode: keep it only in lanes that may use it.
        M better = error < best_.error;
        if (kChannels == 3) better = hn::And(better, opaque_);
        if (modeIndex == 7) better = hn::And(better, hasAlpha_);
        if (hn::AllFalse(D(), better)) return;
        keepFrame(better, error, modeIndex, partition, 0, 0);
        for (int e = 0; e < 2 * kRegions; ++e) {
            best_.low[e] = select(better, coded.low[e], best_.low[e]);
            for (int c = 0; c < kChannels; ++c) best_.code[e][c] = select(better, coded.code[e][c], best_.code[e][c]);
        }
        for (int t = 0; t < kTexelCount; ++t) best_.index[t] = select(better, coded.index[t], best_.index[t]);
    }

    /// Fits mode 4 or 5, in which one channel has indices of its own.
    void trySecondIndex(int modeIndex, int rotation, bool swapIndices) {
        const Bc7Mode& mode = kBc7Modes[static_cast<std::size_t>(modeIndex)];
        const View view = rotated(rotation);
        const int colourIndexBits = swapIndices ? mode.secondIndexBits : mode.indexBits,
                  otherIndexBits = mode.indexBits + mode.secondIndexBits - colourIndexBits;
        const Regions everything{};
        Coded<2, 3> colour;
        Coded<2, 1> other;
        fit<1, 3>(everything, view, {mode.colourBits, LowBits::None, static_cast<float>((1 << colourIndexBits) - 1)}, colour);
        fit<1, 1>(everything, alone(view), {mode.alphaBits, LowBits::None, static_cast<float>((1 << otherIndexBits) - 1)}, other);
        const F error = colour.error + other.error;
        const M better = error < best_.error;
        if (hn::AllFalse(D(), better)) return;
        keepFrame(better, error, modeIndex, hn::Zero(DI()), rotation, swapIndices);
        for (int e = 0; e < 2; ++e) {
            for (int c = 0; c < 3; ++c) best_.code[e][c] = select(better, colour.code[e][c], best_.code[e][c]);
            best_.code[e][3] = select(better, other.code[e][0], best_.code[e][3]);
        }
        for (int t = 0; t < kTexelCount; ++t) {
            best_.index[t] = select(better, colour.index[t], best_.index[t]);
            best_.second[t] = select(better, other.index[t], best_.second[t]);
        }
    }
    /// Sets the error and the mode fields of the best candidate where the mask is set.
    void keepFrame(M better, F error, int mode, I partition, int rotation, int indexSelection) {
        const auto betterI = hn::RebindMask(DI(), better);
        best_.error = select(better, error, best_.error);
        best_.mode = hn::IfThenElse(betterI, hn::Set(DI(), mode), best_.mode);
        best_.partition = hn::IfThenElse(betterI, partition, best_.partition);
        best_.rotation = hn::IfThenElse(betterI, hn::Set(DI(), rotation), best_.rotation);
        best_.indexSelection = hn::IfThenElse(betterI, hn::Set(DI(), indexSelection), best_.indexSelection);
    }

    void tryTwoRegions(const View& view) {
        typename Partitions::Ranking ranking;
        const int keep = search_.twoRegions;
        Partitions(view, lines_.significance).rankTwo(search_.shapes, keep, ranking);
        for (int i = 0; i < keep; ++i) {
            const Regions regions = Regions::template of<2>(ranking.partition[i]);
            if (anyOpaque_) {
                tryMode<2, 3>(1, regions, ranking.partition[i], view);
                tryMode<2, 3>(3, regions, ranking.partition[i], view);
            }
            if (anyAlpha_) tryMode<2, 4>(7, regions, ranking.partition[i], view);
        }
    }

    void tryThreeRegions(const View& view) {
        // Mode 0 has only the first sixteen partitions, so these are ranked separately.
        typename Partitions::Ranking coarse, fine;
        const int keep = search_.threeRegions, keepFine = std::min(keep, 16);
        Partitions(view, lines_.significance).rankThree(keep, keepFine, coarse, fine);
        for (int i = 0; i < keepFine; ++i) tryMode<3, 3>(0, Regions::template of<3>(fine.partition[i]), fine.partition[i], view);
        for (int i = 0; i < keep; ++i) tryMode<3, 3>(2, Regions::template of<3>(coarse.partition[i]), coarse.partition[i], view);
    }

    void store(Bc7Result* found) const {
        const DI di;
        HWY_ALIGN std::int32_t buffer[hn::MaxLanes(D())];
        const std::size_t lanes = hn::Lanes(D());
        const auto each = [&](I value, auto assign) {
            hn::Store(value, di, buffer);
            for (std::size_t lane = 0; lane < lanes; ++lane) assign(found[lane], buffer[lane]);
        };
        const auto byteOf = [](std::int32_t v) { return static_cast<std::uint8_t>(v); };
        HWY_ALIGN float error[hn::MaxLanes(D())];
        hn::Store(best_.error, D(), error);
        for (std::size_t lane = 0; lane < lanes; ++lane) found[lane].error = error[lane];
        each(best_.mode, [](Bc7Result& r, std::int32_t v) { r.mode = v; });
        each(best_.partition, [](Bc7Result& r, std::int32_t v) { r.partition = v; });
        each(best_.rotation, [](Bc7Result& r, std::int32_t v) { r.rotation = v; });
        each(best_.indexSelection, [](Bc7Result& r, std::int32_t v) { r.indexSelection = v; });
        for (std::size_t e = 0; e < 6; ++e) {
            each(hn::ConvertTo(di, best_.low[e]), [&](Bc7Result& r, std::int32_t v) { r.low[e] = byteOf(v); });
            for (std::size_t c = 0; c < 4; ++c)
                each(hn::ConvertTo(di, best_.code[e][c]), [&](Bc7Result& r, std::int32_t v) { r.code[e][c] = byteOf(v); });
        }
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            each(hn::ConvertTo(di, best_.index[t]), [&](Bc7Result& r, std::int32_t v) { r.index[t] = byteOf(v); });
            each(hn::ConvertTo(di, best_.second[t]), [&](Bc7Result& r, std::int32_t v) { r.second[t] = byteOf(v); });
        }
    }

    const Bc7Search& search_;
    const EncodeOptions& options_;
    Bc7Lines<D> lines_;
    F texel_[4][kTexelCount];
    F opaqueError_;        ///< error of replacing alpha by 1
    M opaque_, hasAlpha_;  ///< lanes that may use modes without alpha, and mode 7; some may use both
    bool anyOpaque_ = false, anyAlpha_ = false;
    Candidate best_;
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
