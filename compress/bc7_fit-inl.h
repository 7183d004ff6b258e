// The BC7 encoder's kernel: as many blocks as a vector has lanes, side by side. No lane ever meets another, and every step is a plain
// IEEE operation, so a block gets the same bits at any width. Values are in units of a code, 0 .. 255.
#if defined(LIGHTCOOK_COMPRESS_BC7_FIT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC7_FIT_INL_H_
#undef LIGHTCOOK_COMPRESS_BC7_FIT_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC7_FIT_INL_H_
#endif

#include <hwy/highway.h>

#include <cmath>

#include "compress/bc7_modes.h"
#include "compress/bc7_search.h"
#include "compress/block.h"
#include "compress/partitions.h"

HWY_BEFORE_NAMESPACE();
namespace compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D>
class Bc7Fit {
    using F = hn::Vec<D>;
    using DI = hn::RebindToSigned<D>;
    using I = hn::Vec<DI>;
    using M = hn::Mask<D>;
    using Texels = F[kTexelCount];

public:
    Bc7Fit(const Bc7Search& search, const EncodeOptions& options) : search_(search), options_(options) {}

    /// Codes as many blocks as there are lanes.
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
    /// The channels as a mode sees them, the one on its own last.
    struct View {
        const F* channel[4];
        float weight[4];
    };
    struct Line {
        F a[4], b[4];
    };
    /// Region of each texel, lane by lane.
    struct Regions {
        M second[kTexelCount], third[kTexelCount];
    };
    enum class LowBits { None, PerEnd, PerRegion };
    /// How ends are stored and how many steps lie between them.
    struct Coding {
        int bits;
        LowBits lowBits;
        float steps;
    };
    template <int kEnds, int kChannels>
    struct Coded {
        F error;
        F code[kEnds][kChannels], low[kEnds];
        F index[kTexelCount];
    };
    struct Candidate {
        F error;
        I mode, partition, rotation, indexSelection;
        F code[6][4], low[6];
        F index[kTexelCount], second[kTexelCount];
    };

    static HWY_INLINE F set(float value) { return hn::Set(D(), value); }
    static HWY_INLINE F zero() { return hn::Zero(D()); }
    static HWY_INLINE F clamp(F value, F low, F high) { return hn::Min(hn::Max(value, low), high); }
    static HWY_INLINE F select(M mask, F yes, F no) { return hn::IfThenElse(mask, yes, no); }

    void load(const Block* const* blocks) {
        const D d;
        const std::size_t lanes = hn::Lanes(d);
        HWY_ALIGN float buffer[hn::MaxLanes(D())];
        F total = zero(), opaqueMiss = zero();
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            for (std::size_t lane = 0; lane < lanes; ++lane) buffer[lane] = blocks[lane]->significance[t];
            significance_[t] = hn::Load(d, buffer);
            for (std::size_t c = 0; c < 4; ++c) {
                for (std::size_t lane = 0; lane < lanes; ++lane) buffer[lane] = blocks[lane]->channel[c][t];
                texel_[c][t] = hn::Load(d, buffer) * set(255.0f);
            }
            const F missing = set(255.0f) - texel_[3][t];
            opaqueMiss = opaqueMiss + significance_[t] * missing * missing;
            total = total + significance_[t];
        }
        opaqueError_ = opaqueMiss * set(options_.channelWeights[3]);
        // Nearly opaque is enough for the modes without alpha to be worth a try.
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
    static View alone(const View& view) { return {{view.channel[3], nullptr, nullptr, nullptr}, {view.weight[3], 0, 0, 0}}; }

    // ---- Lines through texels ---------------------------------------------------------------------------------------------------

    template <int kRegions>
    static HWY_INLINE F inRegion(const Regions& regions, int r, int t, F weight) {
        if constexpr (kRegions == 1) return weight;
        if constexpr (kRegions == 2)
            return r ? hn::IfThenElseZero(regions.second[t], weight) : hn::IfThenZeroElse(regions.second[t], weight);
        if (r == 1) return hn::IfThenElseZero(regions.second[t], weight);
        if (r == 2) return hn::IfThenElseZero(regions.third[t], weight);
        return hn::IfThenZeroElse(regions.second[t], hn::IfThenZeroElse(regions.third[t], weight));
    }
    template <int kRegions>
    static HWY_INLINE F pick(const Regions& regions, int t, F first, F second, F third) {
        if constexpr (kRegions == 1) return first;
        const F two = select(regions.second[t], second, first);
        if constexpr (kRegions == 2) return two;
        return select(regions.third[t], third, two);
    }

    /// First positions, in [0, 1], along each region's principal axis.
    template <int kRegions, int kChannels>
    void startPositions(const Regions& regions, const View& view, Texels& position) const {
        for (int r = 0; r < kRegions; ++r) {
            F total = set(1e-30f), mean[kChannels];
            for (F& m : mean) m = zero();
            for (int t = 0; t < kTexelCount; ++t) {
                const F w = inRegion<kRegions>(regions, r, t, significance_[t]);
                total = total + w;
                for (int c = 0; c < kChannels; ++c) mean[c] = mean[c] + w * view.channel[c][t];
            }
            const F share = set(1.0f) / total;
            for (F& m : mean) m = m * share;
            F axis[kChannels];
            principalAxis<kRegions, kChannels>(regions, r, view, mean, axis);
            F low = set(1e30f), high = set(-1e30f), along[kTexelCount];
            for (int t = 0; t < kTexelCount; ++t) {
                along[t] = zero();
                for (int c = 0; c < kChannels; ++c) along[t] = along[t] + (view.channel[c][t] - mean[c]) * axis[c];
                const M counts = inRegion<kRegions>(regions, r, t, significance_[t]) > zero();
                low = select(counts, hn::Min(low, along[t]), low);
                high = select(counts, hn::Max(high, along[t]), high);
            }
            const F perRange = set(1.0f) / hn::Max(high - low, set(1e-20f));
            for (int t = 0; t < kTexelCount; ++t) {
                const F placed = clamp((along[t] - low) * perRange, zero(), set(1.0f));
                position[t] = r == 0 ? placed : pick<kRegions>(regions, t, position[t], r == 1 ? placed : position[t], placed);
            }
        }
    }

    /// Direction, in the space of channels scaled by their weight, by power iteration from the row of the largest diagonal.
    template <int kRegions, int kChannels>
    void principalAxis(const Regions& regions, int r, const View& view, const F (&mean)[kChannels], F (&axis)[kChannels]) const {
        if constexpr (kChannels == 1) {
            axis[0] = set(1.0f);
            return;
        }
        F m[kChannels][kChannels];
        for (auto& row : m)
            for (F& v : row) v = zero();
        for (int t = 0; t < kTexelCount; ++t) {
            const F w = inRegion<kRegions>(regions, r, t, significance_[t]);
            F away[kChannels];
            for (int c = 0; c < kChannels; ++c) away[c] = (view.channel[c][t] - mean[c]) * set(std::sqrt(view.weight[c]));
            for (int i = 0; i < kChannels; ++i)
                for (int j = i; j < kChannels; ++j) m[i][j] = m[i][j] + w * away[i] * away[j];
        }
        for (int i = 0; i < kChannels; ++i)
            for (int j = 0; j < i; ++j) m[i][j] = m[j][i];
        F largest = m[0][0];
        for (int c = 0; c < kChannels; ++c) axis[c] = m[0][c];
        for (int i = 1; i < kChannels; ++i) {
            const M longer = m[i][i] > largest;
            largest = hn::Max(largest, m[i][i]);
            for (int c = 0; c < kChannels; ++c) axis[c] = select(longer, m[i][c], axis[c]);
        }
        for (int iteration = 0; iteration < 4; ++iteration) {
            F norm = set(1e-30f), next[kChannels];
            for (const F& a : axis) norm = hn::Max(norm, hn::Abs(a));
            const F scale = set(1.0f) / norm;
            for (F& a : axis) a = a * scale;
            for (int i = 0; i < kChannels; ++i) {
                next[i] = zero();
                for (int j = 0; j < kChannels; ++j) next[i] = next[i] + m[i][j] * axis[j];
            }
            for (int i = 0; i < kChannels; ++i) axis[i] = next[i];
        }
        // A projection onto the axis weighs channels once more.
        for (int c = 0; c < kChannels; ++c) axis[c] = axis[c] * set(std::sqrt(view.weight[c]));
    }

    /// Least-squares lines for texels at these positions.
    template <int kRegions, int kChannels>
    void leastSquares(const Regions& regions, const View& view, const Texels& position, Line* lines) const {
        for (int r = 0; r < kRegions; ++r) {
            F total = set(1e-30f), meanK = zero(), mean[kChannels];
            for (F& m : mean) m = zero();
            for (int t = 0; t < kTexelCount; ++t) {
                const F w = inRegion<kRegions>(regions, r, t, significance_[t]);
                total = total + w;
                meanK = meanK + w * position[t];
                for (int c = 0; c < kChannels; ++c) mean[c] = mean[c] + w * view.channel[c][t];
            }
            const F share = set(1.0f) / total;
            meanK = meanK * share;
            for (F& m : mean) m = m * share;
            F kk = zero(), kt[kChannels];
            for (F& v : kt) v = zero();
            for (int t = 0; t < kTexelCount; ++t) {
                const F k = position[t] - meanK;
                const F wk = inRegion<kRegions>(regions, r, t, significance_[t]) * k;
                kk = kk + wk * k;
                for (int c = 0; c < kChannels; ++c) kt[c] = kt[c] + wk * (view.channel[c][t] - mean[c]);
            }
            const M distinct = kk > total * set(1e-10f);
            const F perKk = hn::IfThenElseZero(distinct, set(1.0f) / hn::Max(kk, set(1e-35f)));
            for (int c = 0; c < kChannels; ++c) {
                const F slope = kt[c] * perKk;
                lines[r].a[c] = clamp(mean[c] - slope * meanK, zero(), set(255.0f));
                lines[r].b[c] = clamp(mean[c] + slope * (set(1.0f) - meanK), zero(), set(255.0f));
            }
        }
    }

    /// Nearest of steps + 1 values of each texel on its line.
    template <int kRegions, int kChannels>
    void chooseIndices(const Regions& regions, const View& view, const Line* lines, float steps, Texels& index) const {
        F scale[kRegions], weighted[kRegions][kChannels], offset[kRegions];
        for (int r = 0; r < kRegions; ++r) {
            F length = set(1e-20f);
            offset[r] = zero();
            for (int c = 0; c < kChannels; ++c) {
                const F along = lines[r].b[c] - lines[r].a[c];
                weighted[r][c] = along * set(view.weight[c]);
                length = length + weighted[r][c] * along;
                offset[r] = offset[r] + weighted[r][c] * lines[r].a[c];
            }
            scale[r] = set(steps) / length;
            for (F& v : weighted[r]) v = v * scale[r];
            offset[r] = offset[r] * scale[r];
        }
        constexpr int kSecond = kRegions > 1 ? 1 : 0, kThird = kRegions > 2 ? 2 : 0;
        for (int t = 0; t < kTexelCount; ++t) {
            F position = zero() - pick<kRegions>(regions, t, offset[0], offset[kSecond], offset[kThird]);
            for (int c = 0; c < kChannels; ++c)
                position =
                    position + view.channel[c][t] * pick<kRegions>(regions, t, weighted[0][c], weighted[kSecond][c], weighted[kThird][c]);
            index[t] = hn::Round(clamp(position, zero(), set(steps)));
        }
    }
    /// The format's weights are these, rounded: 64 i / 3, 64 i / 7 and 64 i / 15.
    static HWY_INLINE F weightOfIndex(F index, float steps) { return hn::Round(index * set(64.0f / steps)); }

    template <int kRegions, int kChannels>
    F errorOf(const Regions& regions, const View& view, const Line* lines, float steps, const Texels& index) const {
        constexpr int kSecond = kRegions > 1 ? 1 : 0, kThird = kRegions > 2 ? 2 : 0;
        F error = zero();
        for (int t = 0; t < kTexelCount; ++t) {
            const F weight = weightOfIndex(index[t], steps);
            F sum = zero();
            for (int c = 0; c < kChannels; ++c) {
                const F a = pick<kRegions>(regions, t, lines[0].a[c], lines[kSecond].a[c], lines[kThird].a[c]);
                const F b = pick<kRegions>(regions, t, lines[0].b[c], lines[kSecond].b[c], lines[kThird].b[c]);
                // Whole numbers below 2^24: exact.
                const F value = hn::Floor((a * set(64.0f) + (b - a) * weight + set(32.0f)) * set(1.0f / 64));
                const F miss = value - view.channel[c][t];
                sum = sum + set(view.weight[c]) * miss * miss;
            }
            error = error + significance_[t] * sum;
        }
        return error;
    }

    template <int kRegions, int kChannels>
    void refit(const Regions& regions, const View& view, float steps, const Texels& index, Line* lines) const {
        Texels position;
        for (int t = 0; t < kTexelCount; ++t) position[t] = weightOfIndex(index[t], steps) * set(1.0f / 64);
        leastSquares<kRegions, kChannels>(regions, view, position, lines);
    }

    // ---- Codes ------------------------------------------------------------------------------------------------------------------

    /// Eight bits of a value of fewer: the high ones repeated.
    static HWY_INLINE F expand(F value, int bits) {
        if (bits == 8) return value;
        return value * set(static_cast<float>(1 << (8 - bits))) + hn::Floor(value * set(1.0f / static_cast<float>(1 << (2 * bits - 8))));
    }
    static HWY_INLINE F nearestCode(F value, int bits, F low) {
        const bool hasLow = hn::GetLane(low) >= 0;
        const int allBits = bits + hasLow;
        const F scaled = value * set(static_cast<float>((1 << allBits) - 1) / 255.0f);
        const F code = hasLow ? (scaled - low) * set(0.5f) : scaled;
        return hn::Round(clamp(code, zero(), set(static_cast<float>((1 << bits) - 1))));
    }
    static HWY_INLINE F valueOf(F code, const Coding& coding, F low) {
        if (coding.lowBits == LowBits::None) return expand(code, coding.bits);
        return expand(code * set(2.0f) + low, coding.bits + 1);
    }

    /// Rounds ends to codes. forced: bits of the low bits to take (end by end), or -1 for the nearest.
    template <int kRegions, int kChannels>
    void codesOf(const View& view, const Line* lines, const Coding& coding, int forced, Coded<2 * kRegions, kChannels>& out) const {
        for (int e = 0; e < 2 * kRegions; ++e) {
            const F* end = e & 1 ? lines[e / 2].b : lines[e / 2].a;
            out.low[e] = zero();
            if (coding.lowBits == LowBits::None) {
                for (int c = 0; c < kChannels; ++c) out.code[e][c] = nearestCode(end[c], coding.bits, set(-1.0f));
                continue;
            }
            if (forced >= 0)
                out.low[e] = set(static_cast<float>((forced >> (coding.lowBits == LowBits::PerRegion ? e / 2 : e)) & 1));
            else if (coding.lowBits == LowBits::PerEnd || (e & 1) == 0)
                out.low[e] = nearestLowBit<kChannels>(view, lines[e / 2], coding, e & 1);
            else
                out.low[e] = out.low[e - 1];
            for (int c = 0; c < kChannels; ++c) out.code[e][c] = nearestCode(end[c], coding.bits, out.low[e]);
        }
    }
    /// The low bit that leaves an end, or both where they share it, closer to where it should be.
    template <int kChannels>
    F nearestLowBit(const View& view, const Line& line, const Coding& coding, int which) const {
        F error[2];
        for (int bit = 0; bit < 2; ++bit) {
            const F low = set(static_cast<float>(bit));
            error[bit] = zero();
            for (int e = 0; e < 2; ++e) {
                if (coding.lowBits == LowBits::PerEnd && e != which) continue;
                for (int c = 0; c < kChannels; ++c) {
                    const F wanted = e ? line.b[c] : line.a[c];
                    const F miss = valueOf(nearestCode(wanted, coding.bits, low), coding, low) - wanted;
                    error[bit] = error[bit] + set(view.weight[c]) * miss * miss;
                }
            }
        }
        return hn::IfThenElseZero(error[1] < error[0], set(1.0f));
    }
    template <int kRegions, int kChannels>
    static void linesOf(const Coded<2 * kRegions, kChannels>& coded, const Coding& coding, Line* lines) {
        for (int r = 0; r < kRegions; ++r)
            for (int c = 0; c < kChannels; ++c) {
                lines[r].a[c] = valueOf(coded.code[2 * r][c], coding, coded.low[2 * r]);
                lines[r].b[c] = valueOf(coded.code[2 * r + 1][c], coding, coded.low[2 * r + 1]);
            }
    }

    // ---- Search -----------------------------------------------------------------------------------------------------------------

    /// Completes codes by their indices and error, and keeps them where they are better.
    template <int kRegions, int kChannels>
    void evaluate(const Regions& regions, const View& view, const Coding& coding, Coded<2 * kRegions, kChannels>& trial,
                  Coded<2 * kRegions, kChannels>& best) const {
        Line whole[kRegions];
        linesOf<kRegions, kChannels>(trial, coding, whole);
        chooseIndices<kRegions, kChannels>(regions, view, whole, coding.steps, trial.index);
        trial.error = errorOf<kRegions, kChannels>(regions, view, whole, coding.steps, trial.index);
        const M better = trial.error < best.error;
        if (hn::AllFalse(D(), better)) return;
        best.error = select(better, trial.error, best.error);
        for (int e = 0; e < 2 * kRegions; ++e) {
            best.low[e] = select(better, trial.low[e], best.low[e]);
            for (int c = 0; c < kChannels; ++c) best.code[e][c] = select(better, trial.code[e][c], best.code[e][c]);
        }
        for (int t = 0; t < kTexelCount; ++t) best.index[t] = select(better, trial.index[t], best.index[t]);
    }

    /// Fits lines, rounds them, and refits to what rounding made of them.
    template <int kRegions, int kChannels>
    void fit(const Regions& regions, const View& view, const Coding& coding, Coded<2 * kRegions, kChannels>& best) const {
        Texels position;
        Line lines[kRegions];
        Coded<2 * kRegions, kChannels> trial;
        best.error = set(1e30f);
        startPositions<kRegions, kChannels>(regions, view, position);
        leastSquares<kRegions, kChannels>(regions, view, position, lines);
        for (int i = 0; i < search_.freeRefits; ++i) {
            chooseIndices<kRegions, kChannels>(regions, view, lines, coding.steps, trial.index);
            refit<kRegions, kChannels>(regions, view, coding.steps, trial.index, lines);
        }
        for (int i = 0; i <= search_.codedRefits; ++i) {
            if (i > 0) refit<kRegions, kChannels>(regions, view, coding.steps, trial.index, lines);
            codesOf<kRegions, kChannels>(view, lines, coding, -1, trial);
            evaluate<kRegions, kChannels>(regions, view, coding, trial, best);
        }
        if (search_.everyLowBit && coding.lowBits != LowBits::None) {
            refit<kRegions, kChannels>(regions, view, coding.steps, best.index, lines);
            const int bitCount = coding.lowBits == LowBits::PerEnd ? 2 * kRegions : kRegions;
            for (int forced = 0; forced < 1 << bitCount; ++forced) {
                codesOf<kRegions, kChannels>(view, lines, coding, forced, trial);
                evaluate<kRegions, kChannels>(regions, view, coding, trial, best);
            }
        }
        for (int pass = 0; pass < search_.descents; ++pass) descend<kRegions, kChannels>(regions, view, coding, best);
    }
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

    static Coding codingOf(const Bc7Mode& mode) {
        const LowBits low = mode.endpointLowBits ? LowBits::PerEnd : mode.sharedLowBits ? LowBits::PerRegion : LowBits::None;
        return {mode.colourBits, low, static_cast<float>((1 << mode.indexBits) - 1)};
    }

    /// A mode with one index.
    template <int kRegions, int kChannels>
    void tryMode(int modeIndex, const Regions& regions, I partition, const View& view) {
        Coded<2 * kRegions, kChannels> coded;
        fit<kRegions, kChannels>(regions, view, codingOf(kBc7Modes[static_cast<std::size_t>(modeIndex)]), coded);
        const F error = kChannels == 4 ? coded.error : coded.error + opaqueError_;
        // A mode is tried when any lane asks for it; what the neighbours ask for must not change a block.
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

    /// Modes 4 and 5: one channel has an index of its own.
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
    void keepFrame(M better, F error, int mode, I partition, int rotation, int indexSelection) {
        const auto betterI = hn::RebindMask(DI(), better);
        best_.error = select(better, error, best_.error);
        best_.mode = hn::IfThenElse(betterI, hn::Set(DI(), mode), best_.mode);
        best_.partition = hn::IfThenElse(betterI, partition, best_.partition);
        best_.rotation = hn::IfThenElse(betterI, hn::Set(DI(), rotation), best_.rotation);
        best_.indexSelection = hn::IfThenElse(betterI, hn::Set(DI(), indexSelection), best_.indexSelection);
    }

    // ---- Partitions -------------------------------------------------------------------------------------------------------------

    static constexpr int kMoments = 15, kMostKept = 64;
    struct Moments {
        F v[kMoments];  ///< w; w times each channel; w times each product of two
    };
    struct Ranking {
        F score[kMostKept];
        I partition[kMostKept];
    };

    void moments(const View& view, Moments (&of)[kTexelCount], Moments& total) const {
        for (F& v : total.v) v = zero();
        F mean[4] = {zero(), zero(), zero(), zero()}, weight = zero();
        for (int t = 0; t < kTexelCount; ++t) {
            weight = weight + significance_[t];
            for (int c = 0; c < 4; ++c) mean[c] = mean[c] + significance_[t] * view.channel[c][t];
        }
        const F share = set(1.0f) / weight;
        for (int t = 0; t < kTexelCount; ++t) {
            F away[4];
            for (int c = 0; c < 4; ++c) away[c] = (view.channel[c][t] - mean[c] * share) * set(std::sqrt(view.weight[c]));
            F* out = of[t].v;
            *out++ = significance_[t];
            for (int c = 0; c < 4; ++c) *out++ = significance_[t] * away[c];
            for (int i = 0; i < 4; ++i)
                for (int j = i; j < 4; ++j) *out++ = significance_[t] * away[i] * away[j];
            for (int i = 0; i < kMoments; ++i) total.v[i] = total.v[i] + of[t].v[i];
        }
    }
    /// What lies off the axis of texels with these moments, and the width of a step on it. The largest eigenvalue is taken as the norm of
    /// the matrix: right where one direction rules, which is where it matters.
    static HWY_INLINE F estimateError(const F* m, float quantizationShare) {
        const F share = set(1.0f) / hn::Max(m[0], set(1e-30f));
        F trace = zero(), squares = zero();
        int at = 5;
        for (int i = 0; i < 4; ++i)
            for (int j = i; j < 4; ++j) {
                const F v = m[at++] - m[1 + i] * m[1 + j] * share;
                if (i == j) trace = trace + v;
                squares = squares + (i == j ? v * v : set(2.0f) * v * v);
            }
        const F norm = hn::Sqrt(squares);
        return hn::Max(trace - norm, zero()) + norm * set(quantizationShare);
    }
    static void insert(F error, int partition, int keep, Ranking& ranking) {
        I candidate = hn::Set(DI(), partition);
        for (int i = 0; i < keep; ++i) {  // what is pushed out moves on
            const M better = error < ranking.score[i];
            const auto betterI = hn::RebindMask(DI(), better);
            const F lost = select(better, ranking.score[i], error);
            const I lostCandidate = hn::IfThenElse(betterI, ranking.partition[i], candidate);
            ranking.score[i] = hn::Min(ranking.score[i], error);
            ranking.partition[i] = hn::IfThenElse(betterI, candidate, ranking.partition[i]);
            error = lost;
            candidate = lostCandidate;
        }
    }
    static void clear(int keep, Ranking& ranking) {
        for (int i = 0; i < keep; ++i) {
            ranking.score[i] = set(1e30f);
            ranking.partition[i] = hn::Zero(DI());
        }
    }

    void tryTwoRegions(const View& view) {
        Moments moment[kTexelCount], total;
        moments(view, moment, total);
        Ranking ranking;
        const int keep = search_.twoRegions;
        clear(keep, ranking);
        for (int p = 0; p < search_.shapes; ++p) {
            F first[kMoments], second[kMoments];
            for (int i = 0; i < kMoments; ++i) {
                F sum = zero();
                for (int t = 0; t < kTexelCount; ++t)
                    if (regionOf(2, p, t) == 1) sum = sum + moment[t].v[i];
                second[i] = sum;
                first[i] = total.v[i] - sum;
            }
            insert(estimateError(first, 1.0f / 49) + estimateError(second, 1.0f / 49), p, keep, ranking);
        }
        for (int i = 0; i < keep; ++i) {
            const Regions regions = regionsOf<2>(ranking.partition[i]);
            if (anyOpaque_) {
                tryMode<2, 3>(1, regions, ranking.partition[i], view);
                tryMode<2, 3>(3, regions, ranking.partition[i], view);
            }
            if (anyAlpha_) tryMode<2, 4>(7, regions, ranking.partition[i], view);
        }
    }

    void tryThreeRegions(const View& view) {
        Moments moment[kTexelCount], total;
        moments(view, moment, total);
        // Mode 0 knows only the first sixteen, so these have a ranking of their own.
        Ranking coarse, fine;
        const int keep = search_.threeRegions, keepFine = std::min(keep, 16);
        clear(keep, coarse);
        clear(keepFine, fine);
        for (int p = 0; p < 64; ++p) {
            F sums[3][kMoments];
            for (int i = 0; i < kMoments; ++i) {
                sums[1][i] = sums[2][i] = zero();
                for (int t = 0; t < kTexelCount; ++t) {
                    const int r = regionOf(3, p, t);
                    if (r > 0) sums[r][i] = sums[r][i] + moment[t].v[i];
                }
                sums[0][i] = total.v[i] - sums[1][i] - sums[2][i];
            }
            F error = zero();
            for (const auto& sum : sums) error = error + estimateError(sum, 1.0f / 49);
            insert(error, p, keep, coarse);
            if (p < 16) insert(error, p, keepFine, fine);
        }
        for (int i = 0; i < keepFine; ++i) tryMode<3, 3>(0, regionsOf<3>(fine.partition[i]), fine.partition[i], view);
        for (int i = 0; i < keep; ++i) tryMode<3, 3>(2, regionsOf<3>(coarse.partition[i]), coarse.partition[i], view);
    }

    template <int kRegions>
    static Regions regionsOf(I partition) {
        const D d;
        const DI di;
        HWY_ALIGN std::int32_t number[hn::MaxLanes(D())], second[hn::MaxLanes(D())], third[hn::MaxLanes(D())];
        hn::Store(partition, di, number);
        for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) {
            second[lane] = third[lane] = 0;
            for (int t = 0; t < kTexelCount; ++t) {
                const int r = regionOf(kRegions, number[lane], t);
                second[lane] |= (r == 1) << t;
                third[lane] |= (r == 2) << t;
            }
        }
        const I seconds = hn::Load(di, second), thirds = hn::Load(di, third);
        Regions regions;
        for (int t = 0; t < kTexelCount; ++t) {
            regions.second[t] = hn::RebindMask(d, hn::TestBit(seconds, hn::Set(di, 1 << t)));
            regions.third[t] = hn::RebindMask(d, hn::TestBit(thirds, hn::Set(di, 1 << t)));
        }
        return regions;
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
    F texel_[4][kTexelCount];
    F significance_[kTexelCount];
    F opaqueError_;        ///< of taking alpha for 1
    M opaque_, hasAlpha_;  ///< lanes for modes without alpha, and for those with it; some may be both
    bool anyOpaque_ = false, anyAlpha_ = false;
    Candidate best_;
};

}  // namespace HWY_NAMESPACE
}  // namespace compress
HWY_AFTER_NAMESPACE();
#endif
