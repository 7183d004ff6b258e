// BC7, full search: fits a given mode to blocks, one in each lane, with all rounding of the decoder. Values are in 0 .. 255.
//
// Method, with the counts given by Bc7Search. Texels are projected onto the principal axis of their region. Starts place them on ranges of
// the indices: all, all but the last, all but the first, ...; the line is the same, but its ends lie beyond the texels, so that other
// interpolated values meet them. The ends are rounded to codes, refitted to the nearest indices, and moved by single steps (coordinate
// descent). Regions do not depend on each other, so each keeps its own best codes, and a trial counts for all of them at once.
#if defined(LIGHTCOOK_COMPRESS_BC7_FULL_POLISH_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC7_FULL_POLISH_INL_H_
#undef LIGHTCOOK_COMPRESS_BC7_FULL_POLISH_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC7_FULL_POLISH_INL_H_
#endif

#include <hwy/highway.h>

#include "compress/bc7/full/codes-inl.h"
#include "compress/bc7/full/lines-inl.h"
#include "compress/bc7/search.h"
#include "compress/block/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D>
class Bc7Polish : Lanes<D> {
    using typename Lanes<D>::F, typename Lanes<D>::M, typename Lanes<D>::DI, typename Lanes<D>::I;
    using Lanes<D>::set, Lanes<D>::zero, Lanes<D>::clamp, Lanes<D>::select;
    using View = Bc7View<D>;
    using Line = Bc7Line<D>;
    using Regions = Bc7Regions<D>;
    using Codes = Bc7Codes<D>;
    using Coding = Bc7Coding;
    using LowBits = Bc7LowBits;
    template <int kRegions, int kChannels>
    using Coded = Bc7Coded<D, kRegions, kChannels>;
    using Texels = F[kTexelCount];

public:
    Bc7Polish(const Bc7Search& search, const EncodeOptions& options) : search_(search), options_(options) {}

    /// Encodes Lanes(d) blocks by candidates that differ in their partition alone. Results go to found, one after the other.
    void run(const Block* const* blocks, const std::int32_t* numbers, Bc7Result* found) {
        load(blocks);
        const Bc7Candidate candidate = Bc7Candidate::of(numbers[0]);
        HWY_ALIGN std::int32_t partitions[hn::MaxLanes(D())];
        for (std::size_t lane = 0; lane < hn::Lanes(D()); ++lane) partitions[lane] = Bc7Candidate::of(numbers[lane]).partition;
        fitMode(candidate, hn::Load(DI(), partitions));
        store(candidate, partitions, found);
    }

private:
    void load(const Block* const* blocks) {
        const D d;
        const std::size_t lanes = hn::Lanes(d);
        HWY_ALIGN float buffer[hn::MaxLanes(D())];
        F opaqueMiss = zero();
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            for (std::size_t lane = 0; lane < lanes; ++lane) buffer[lane] = blocks[lane]->significance[t];
            lines_.significance[t] = hn::Load(d, buffer);
            for (std::size_t c = 0; c < 4; ++c) {
                for (std::size_t lane = 0; lane < lanes; ++lane) buffer[lane] = blocks[lane]->channel[c][t];
                texel_[c][t] = hn::Load(d, buffer) * set(255.0f);
            }
            const F missing = set(255.0f) - texel_[3][t];
            opaqueMiss = opaqueMiss + lines_.significance[t] * missing * missing;
        }
        opaqueError_ = opaqueMiss * set(options_.channelWeights[3]);
    }

    /// Returns the channels with alpha swapped for channel rotation - 1; 0: not swapped.
    View rotated(int rotation) const {
        View view;
        for (std::size_t c = 0; c < 4; ++c) {
            const std::size_t source = rotatedChannel(rotation, c);
            view.channel[c] = texel_[source];
            view.weight[c] = options_.channelWeights[source];
        }
        return view;
    }
    /// Returns the view of the separate channel alone.
    static View alone(const View& view) { return {{view.channel[3], nullptr, nullptr, nullptr}, {view.weight[3], 0, 0, 0}}; }

    /// Computes the errors of the regions for codes, and keeps the codes of the regions where they are better.
    /// index  receives the nearest indices. May be null
    template <int kRegions, int kChannels>
    void evaluate(const Regions& regions, const View& view, const Coding& coding, Coded<kRegions, kChannels>& trial,
                  Coded<kRegions, kChannels>& best, Texels* index = nullptr) const {
        Line lines[kRegions];
        Codes::template linesOf<kRegions, kChannels>(trial, coding, lines);
        lines_.template errorsOf<kRegions, kChannels>(regions, view, lines, coding.steps, trial.error, index);
        for (int r = 0; r < kRegions; ++r) {
            const M better = trial.error[r] < best.error[r];
            best.error[r] = hn::Min(trial.error[r], best.error[r]);
            for (int e = 2 * r; e < 2 * r + 2; ++e) {
                best.low[e] = select(better, trial.low[e], best.low[e]);
                for (int c = 0; c < kChannels; ++c) best.code[e][c] = select(better, trial.code[e][c], best.code[e][c]);
            }
        }
    }
    /// Chooses the indices for the best codes.
    template <int kRegions, int kChannels>
    void indicesOf(const Regions& regions, const View& view, const Coding& coding, const Coded<kRegions, kChannels>& best,
                   Texels& index) const {
        Line lines[kRegions];
        F error[kRegions];
        Codes::template linesOf<kRegions, kChannels>(best, coding, lines);
        lines_.template errorsOf<kRegions, kChannels>(regions, view, lines, coding.steps, error, &index);
    }

    /// Fits the lines of a mode, as the head of this file says.
    template <int kRegions, int kChannels>
    void fit(const Regions& regions, const View& view, const Coding& coding, Coded<kRegions, kChannels>& best, Texels& index) const {
        for (F& error : best.error) error = set(1e30f);
        for (int e = 0; e < 2 * kRegions; ++e) {
            best.low[e] = zero();
            for (F& code : best.code[e]) code = zero();
        }
        Texels position;
        Line line[kRegions];
        lines_.template startPositions<kRegions, kChannels>(regions, view, position);
        lines_.template leastSquares<kRegions, kChannels>(regions, view, position, line);
        const int steps = static_cast<int>(coding.steps);
        int starts = search_.starts;
        for (int range = steps; range >= 1; --range)
            for (int from = 0; from + range <= steps && starts > 0; ++from, --starts)
                fitStart<kRegions, kChannels>(regions, view, coding, line, static_cast<float>(from), static_cast<float>(range), best);
        for (int pass = 0; pass < search_.descents; ++pass) {
            refit<kRegions, kChannels>(regions, view, coding, best);
            descend<kRegions, kChannels>(regions, view, coding, best);
        }
        indicesOf<kRegions, kChannels>(regions, view, coding, best, index);
    }
    /// Fits a start: the texels lie on the indices `from` to `from + range`.
    template <int kRegions, int kChannels>
    void fitStart(const Regions& regions, const View& view, const Coding& coding, const Line (&line)[kRegions], float from, float range,
                  Coded<kRegions, kChannels>& best) const {
        Texels index;
        Line lines[kRegions];
        Coded<kRegions, kChannels> trial;
        for (int r = 0; r < kRegions; ++r) lines[r] = line[r].template moved<kChannels>(from / coding.steps, range / coding.steps);
        for (int i = 0; i <= search_.startRefits; ++i) {
            if (i > 0) lines_.template refit<kRegions, kChannels>(regions, view, coding.steps, index, lines);
            Codes::template codesOf<kRegions, kChannels>(view, lines, coding, -1, trial);
            evaluate<kRegions, kChannels>(regions, view, coding, trial, best, i < search_.startRefits ? &index : nullptr);
        }
    }
    /// Fits lines to the best indices, and rounds them with each choice of low bits.
    template <int kRegions, int kChannels>
    void refit(const Regions& regions, const View& view, const Coding& coding, Coded<kRegions, kChannels>& best) const {
        Texels index;
        Line lines[kRegions];
        Coded<kRegions, kChannels> trial;
        indicesOf<kRegions, kChannels>(regions, view, coding, best, index);
        lines_.template refit<kRegions, kChannels>(regions, view, coding.steps, index, lines);
        for (int i = 0; i < Codes::choicesOf(coding); ++i) {
            Codes::template codesOf<kRegions, kChannels>(view, lines, coding, i, trial);
            evaluate<kRegions, kChannels>(regions, view, coding, trial, best);
        }
    }
    /// Runs one pass of coordinate descent.
    template <int kRegions, int kChannels>
    void descend(const Regions& regions, const View& view, const Coding& coding, Coded<kRegions, kChannels>& best) const {
        const F largest = set(static_cast<float>((1 << coding.bits) - 1));
        const auto step = [&](int channel, float first, float second) {
            Coded<kRegions, kChannels> trial = best;
            for (int r = 0; r < kRegions; ++r) {
                F &a = trial.code[2 * r][channel], &b = trial.code[2 * r + 1][channel];
                a = clamp(a + set(first), zero(), largest);
                b = clamp(b + set(second), zero(), largest);
            }
            evaluate<kRegions, kChannels>(regions, view, coding, trial, best);
        };
        for (int c = 0; c < kChannels; ++c) {
            step(c, -1, 0);
            step(c, 1, 0);
            step(c, 0, -1);
            step(c, 0, 1);
            if (search_.pairs) {
                step(c, -1, 1);
                step(c, 1, -1);
            }
        }
    }

    void fitMode(const Bc7Candidate& candidate, I partition) {
        switch (candidate.mode) {
            case 0:
            case 2:
                return fitRegions<3, 3>(candidate.mode, partition);
            case 1:
            case 3:
                return fitRegions<2, 3>(candidate.mode, partition);
            case 7:
                return fitRegions<2, 4>(candidate.mode, partition);
            case 6:
                return fitRegions<1, 4>(candidate.mode, partition);
            default:
                return fitTwoIndices(candidate);
        }
    }
    /// Fits a mode with one index for all channels.
    template <int kRegions, int kChannels>
    void fitRegions(int mode, I partition) {
        const Regions regions = kRegions > 1 ? Regions::template of<kRegions>(partition) : Regions{};
        Coded<kRegions, kChannels> coded;
        fit<kRegions, kChannels>(regions, rotated(0), Coding::of(kBc7Modes[static_cast<std::size_t>(mode)]), coded, index_);
        error_ = kChannels == 4 ? zero() : opaqueError_;
        for (const F& error : coded.error) error_ = error_ + error;
        for (int e = 0; e < 6; ++e) {
            const bool has = e < 2 * kRegions;
            low_[e] = has ? coded.low[e] : zero();
            for (int c = 0; c < 4; ++c) code_[e][c] = has && c < kChannels ? coded.code[e][c] : zero();
        }
        for (F& index : second_) index = zero();
    }
    /// Fits mode 4 or 5, in which one channel has indices of its own.
    void fitTwoIndices(const Bc7Candidate& candidate) {
        const Bc7Mode& mode = kBc7Modes[static_cast<std::size_t>(candidate.mode)];
        const View view = rotated(candidate.rotation);
        const int colourIndexBits = candidate.indexSelection ? mode.secondIndexBits : mode.indexBits,
                  otherIndexBits = mode.indexBits + mode.secondIndexBits - colourIndexBits;
        const Regions everything{};
        Coded<1, 3> colour;
        Coded<1, 1> other;
        fit<1, 3>(everything, view, {mode.colourBits, LowBits::None, static_cast<float>((1 << colourIndexBits) - 1)}, colour, index_);
        fit<1, 1>(everything, alone(view), {mode.alphaBits, LowBits::None, static_cast<float>((1 << otherIndexBits) - 1)}, other, second_);
        error_ = colour.error[0] + other.error[0];
        for (int e = 0; e < 6; ++e) {
            low_[e] = zero();
            for (int c = 0; c < 4; ++c) code_[e][c] = e > 1 ? zero() : c < 3 ? colour.code[e][c] : other.code[e][0];
        }
    }

    void store(const Bc7Candidate& candidate, const std::int32_t* partitions, Bc7Result* found) const {
        const DI di;
        HWY_ALIGN std::int32_t buffer[hn::MaxLanes(D())];
        HWY_ALIGN float error[hn::MaxLanes(D())];
        const std::size_t lanes = hn::Lanes(D());
        hn::Store(error_, D(), error);
        for (std::size_t lane = 0; lane < lanes; ++lane) {
            found[lane].error = error[lane];
            found[lane].mode = candidate.mode;
            found[lane].partition = partitions[lane];
            found[lane].rotation = candidate.rotation;
            found[lane].indexSelection = candidate.indexSelection;
        }
        const auto each = [&](F value, auto assign) {
            hn::Store(hn::ConvertTo(di, value), di, buffer);
            for (std::size_t lane = 0; lane < lanes; ++lane) assign(found[lane]) = static_cast<std::uint8_t>(buffer[lane]);
        };
        for (std::size_t e = 0; e < 6; ++e) {
            each(
                low_[e], [&](Bc7Result & r) -> auto& { return r.low[e]; });
            for (std::size_t c = 0; c < 4; ++c)
                each(
                    code_[e][c], [&](Bc7Result & r) -> auto& { return r.code[e][c]; });
        }
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            each(
                index_[t], [&](Bc7Result & r) -> auto& { return r.index[t]; });
            each(
                second_[t], [&](Bc7Result & r) -> auto& { return r.second[t]; });
        }
    }

    const Bc7Search& search_;
    const EncodeOptions& options_;
    Bc7Lines<D> lines_;
    F texel_[4][kTexelCount];
    F opaqueError_;  ///< error of replacing alpha by 1
    // The result:
    F error_, code_[6][4], low_[6], index_[kTexelCount], second_[kTexelCount];
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
