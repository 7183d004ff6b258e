// BC7, fast kernel: the best candidate of each lane, its final indices, and the words that are packed into a block.
#if defined(LIGHTCOOK_COMPRESS_BC7_FAST_BLOCK_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC7_FAST_BLOCK_INL_H_
#undef LIGHTCOOK_COMPRESS_BC7_FAST_BLOCK_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC7_FAST_BLOCK_INL_H_
#endif

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>

#include "compress/bc7/closed_form/least_squares-inl.h"
#include "compress/bc7/closed_form/texels-inl.h"
#include "compress/bc7/fast/pack.h"
#include "compress/bc7/modes.h"
#include "compress/block/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D>
class Bc7FastBlock : Lanes<D> {
    using typename Lanes<D>::F, typename Lanes<D>::M, typename Lanes<D>::DI, typename Lanes<D>::I;
    using Lanes<D>::set, Lanes<D>::zero, Lanes<D>::clamp, Lanes<D>::select;
    using Texels = Bc7ScaledTexels<D>;
    using Ends = Bc7RoundedEnds<D>;

public:
    F error;  ///< of the best candidate

    /// Forgets the candidates. Only those with an error below the bound will be kept.
    void clear(F bound) {
        error = bound;
        mode_ = choice_ = low_ = hn::Zero(DI());
        for (int c = 0; c < 4; ++c) {
            word_[c] = hn::Zero(DI());
            for (auto& line : value_)
                for (auto& end : line) end[c] = zero();
        }
        perIndex_ = perOther_ = hn::Zero(DI());
        steps_ = otherSteps_ = zero();
        anyMode5_ = false;
    }
    /// Keeps a candidate with one or two regions where it is better.
    /// opaqueAlpha  value of alpha where the mode has none
    template <int kRegions, int kChannels>
    void keep(M allowed, F opaqueAlpha, F candidateError, int mode, I choice, const Ends (&ends)[kRegions]) {
        const M better = hn::And(allowed, candidateError < error);
        if (hn::AllFalse(D(), better)) return;
        const Bc7Mode& m = kBc7Modes[static_cast<std::size_t>(mode)];
        keepFrame(better, candidateError, mode, choice, m.indexBits, 0);
        const auto betterI = hn::RebindMask(DI(), better);
        I low = hn::Zero(DI());
        for (int r = 0; r < kRegions; ++r)
            for (int e = 0; e < 2; ++e) {
                if (m.sharedLowBits && e) continue;
                const int bit = m.sharedLowBits ? r : 2 * r + e;
                low = hn::Or(low, shifted(ends[r].low[e], bit));
            }
        low_ = hn::IfThenElse(betterI, low, low_);
        for (int c = 0; c < 4; ++c) {
            if (c < kChannels) keepWord<kRegions>(better, c, m.colourBits, ends);
            for (int r = 0; r < 2; ++r)
                for (int e = 0; e < 2; ++e)
                    value_[r][e][c] = select(better,
                                             r >= kRegions   ? zero()
                                             : c < kChannels ? ends[r].value[e][c]
                                                             : opaqueAlpha,
                                             value_[r][e][c]);
        }
    }
    /// Keeps a candidate of mode 5 without rotation where it is better.
    /// alpha  ends of alpha, as their channel 0
    void keepMode5(F candidateError, const Ends (&colour)[1], const Ends (&alpha)[1]) {
        const M better = candidateError < error;
        if (hn::AllFalse(D(), better)) return;
        constexpr Bc7Mode kMode = kBc7Modes[5];
        keepFrame(better, candidateError, 5, hn::Zero(DI()), kMode.indexBits, kMode.secondIndexBits);
        anyMode5_ = true;
        const auto betterI = hn::RebindMask(DI(), better);
        low_ = hn::IfThenZeroElse(betterI, low_);
        for (int c = 0; c < 3; ++c) keepWord<1>(better, c, kMode.colourBits, colour);
        const I word = hn::Or(hn::ConvertTo(DI(), alpha[0].code[0][0]), shifted(alpha[0].code[1][0], kMode.alphaBits));
        word_[3] = hn::IfThenElse(betterI, word, word_[3]);
        // The line of alpha is that of region 1.
        for (std::size_t e = 0; e < 2; ++e) {
            for (std::size_t c = 0; c < 3; ++c) {
                value_[0][e][c] = select(better, colour[0].value[e][c], value_[0][e][c]);
                value_[1][e][c] = hn::IfThenZeroElse(better, value_[1][e][c]);
            }
            value_[0][e][3] = hn::IfThenZeroElse(better, value_[0][e][3]);
            value_[1][e][3] = select(better, alpha[0].value[e][0], value_[1][e][3]);
        }
    }

    /// Chooses the indices for the decoded ends, and packs the blocks of the first `count` lanes.
    /// out    returns where the 16 bytes of a lane go, or null if the lane is not needed
    template <class Out>
    void finish(const Texels& texels, std::size_t count, const Out& out) const {
        const DI di;
        Line line[2];
        for (int r = 0; r < 2; ++r) line[r] = lineOf(texels, r);
        HWY_ALIGN std::int32_t words[kWords][kLanes];
        I index[2] = {hn::Zero(di), hn::Zero(di)}, other[2] = {hn::Zero(di), hn::Zero(di)};
        I place = hn::Set(di, 1), otherPlace = place;
        for (int t = 0; t < kTexelCount; ++t) {
            if (t == 8) place = otherPlace = hn::Set(di, 1);
            const M second = hn::RebindMask(D(), hn::TestBit(choice_, hn::Set(di, static_cast<std::int32_t>(0x10000u << t))));
            F position = select(second, line[1].offset, line[0].offset);
            for (int c = 0; c < 4; ++c) position = hn::MulAdd(texels.x[c][t], select(second, line[1].d[c], line[0].d[c]), position);
            const F nearest = hn::Round(clamp(position, zero(), steps_));
            const I i = hn::ConvertTo(di, nearest);
            index[t / 8] = hn::Or(index[t / 8], i * place);
            place = place * perIndex_;
            if (!anyMode5_) continue;
            F apart = line[1].offset;
            for (int c = 0; c < 4; ++c) apart = hn::MulAdd(texels.x[c][t], line[1].d[c], apart);
            other[t / 8] = hn::Or(other[t / 8], hn::ConvertTo(di, hn::Round(clamp(apart, zero(), otherSteps_))) * otherPlace);
            otherPlace = otherPlace * perOther_;
        }
        const I all[kWords] = {mode_, choice_, low_, word_[0], word_[1], word_[2], word_[3], index[0], index[1], other[0], other[1]};
        for (int i = 0; i < kWords; ++i) hn::Store(all[i], di, words[i]);
        for (std::size_t lane = 0; lane < count; ++lane) {
            std::byte* const to = out(lane);
            if (!to) continue;
            Bc7Words block;
            const auto word = [&](int i) { return static_cast<std::uint32_t>(words[i][lane]); };
            block.mode = words[0][lane];
            block.partition = words[1][lane] & 63;
            block.low = word(2);
            for (int c = 0; c < 4; ++c) block.code[static_cast<std::size_t>(c)] = word(3 + c);
            block.index = {word(7), word(8)};
            block.second = {word(9), word(10)};
            packBc7(block, to);
        }
    }

private:
    static constexpr std::size_t kLanes = hn::MaxLanes(D());
    static constexpr int kWords = 11;
    /// Index = offset + sum over channels of d x.
    struct Line {
        F d[4], offset;
    };
    Line lineOf(const Texels& texels, int region) const {
        Line line;
        F square = zero();
        for (int c = 0; c < 4; ++c) {
            line.d[c] = value_[region][1][c] - value_[region][0][c];
            square = hn::MulAdd(line.d[c], line.d[c], square);
        }
        F steps = steps_;
        if (region == 1) steps = select(isMode5(), otherSteps_, steps_);
        const F scale = steps / hn::Max(square, set(1e-12f));
        line.offset = zero();
        for (int c = 0; c < 4; ++c) {
            line.d[c] = line.d[c] * scale;
            line.offset = hn::MulAdd(texels.mean[c] - value_[region][0][c], line.d[c], line.offset);
        }
        return line;
    }
    M isMode5() const { return otherSteps_ > zero(); }

    static HWY_INLINE I shifted(F code, int bits) {
        const I i = hn::ConvertTo(DI(), code);
        return bits == 0 ? i : hn::ShiftLeftSame(i, bits);
    }
    /// Sets the codes of a channel of the best candidate where the mask is set.
    template <int kRegions>
    void keepWord(M better, int channel, int bits, const Ends (&ends)[kRegions]) {
        I word = hn::Zero(DI());
        for (int r = 0; r < kRegions; ++r)
            for (int e = 0; e < 2; ++e) word = hn::Or(word, shifted(ends[r].code[e][channel], bits * (2 * r + e)));
        word_[channel] = hn::IfThenElse(hn::RebindMask(DI(), better), word, word_[channel]);
    }
    /// Sets the error, the mode fields and the index counts of the best candidate where the mask is set.
    void keepFrame(M better, F candidateError, int mode, I choice, int indexBits, int otherBits) {
        const auto betterI = hn::RebindMask(DI(), better);
        const auto stepsOf = [](int bits) { return static_cast<float>((1 << bits) - 1); };
        error = select(better, candidateError, error);
        mode_ = hn::IfThenElse(betterI, hn::Set(DI(), mode), mode_);
        choice_ = hn::IfThenElse(betterI, choice, choice_);
        perIndex_ = hn::IfThenElse(betterI, hn::Set(DI(), 1 << indexBits), perIndex_);
        perOther_ = hn::IfThenElse(betterI, hn::Set(DI(), 1 << otherBits), perOther_);
        steps_ = select(better, set(stepsOf(indexBits)), steps_);
        otherSteps_ = select(better, set(stepsOf(otherBits)), otherSteps_);
    }

    I mode_, choice_, low_, word_[4];
    F value_[2][2][4];       ///< decoded ends of each region and channel
    I perIndex_, perOther_;  ///< number of indices, a power of two: a factor shifts by an index (Shl fails on one lane)
    F steps_, otherSteps_;   ///< of the indices of alpha in mode 5, else 0
    bool anyMode5_;
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
