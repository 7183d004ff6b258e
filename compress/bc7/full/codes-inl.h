// BC7: rounds the ends of lines to codes of a mode, with their low bits, and converts codes back to values.
#if defined(LIGHTCOOK_COMPRESS_BC7_FULL_CODES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC7_FULL_CODES_INL_H_
#undef LIGHTCOOK_COMPRESS_BC7_FULL_CODES_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC7_FULL_CODES_INL_H_
#endif

#include <hwy/highway.h>

#include "compress/bc7/full/lines-inl.h"
#include "compress/bc7/modes.h"
#include "compress/block/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

enum class Bc7LowBits { None, PerEnd, PerRegion };

/// Storage of the ends of a region, and the number of index steps between them.
struct Bc7Coding {
    int bits;
    Bc7LowBits lowBits;
    float steps;

    static Bc7Coding of(const Bc7Mode& mode) {
        const auto low = mode.endpointLowBits ? Bc7LowBits::PerEnd : mode.sharedLowBits ? Bc7LowBits::PerRegion : Bc7LowBits::None;
        return {mode.colourBits, low, static_cast<float>((1 << mode.indexBits) - 1)};
    }
};

/// Rounded ends of each region, and its error.
template <class D, int kRegions, int kChannels>
struct Bc7Coded {
    hn::Vec<D> error[kRegions];
    hn::Vec<D> code[2 * kRegions][kChannels], low[2 * kRegions];
};

template <class D>
class Bc7Codes : Lanes<D> {
    using typename Lanes<D>::F;
    using Lanes<D>::set, Lanes<D>::zero, Lanes<D>::clamp;
    using View = Bc7View<D>;
    using Line = Bc7Line<D>;
    using Coding = Bc7Coding;
    using LowBits = Bc7LowBits;
    template <int kRegions, int kChannels>
    using Coded = Bc7Coded<D, kRegions, kChannels>;

public:
    /// Rounds the ends of lines by least squares to the codes, and their low bits, of about the least error for the positions of the lines:
    /// in each channel, the first end takes the codes on both sides, and the second end the best code for each of them.
    /// only  choice of the low bits, below choicesOf(coding); -1: the best one
    template <int kRegions, int kChannels>
    static void codesOf(const View& view, const Line* lines, const Coding& coding, int only, Coded<kRegions, kChannels>& out) {
        for (int r = 0; r < kRegions; ++r) {
            F least = set(1e30f);
            const Form form(lines[r]);
            for (int choice = only < 0 ? 0 : only; choice < (only < 0 ? choicesOf(coding) : only + 1); ++choice) {
                const LowPair low(coding, choice);
                F error = zero(), code[2][kChannels];
                for (int c = 0; c < kChannels; ++c)
                    error = hn::MulAdd(set(view.weight[c]), roundPair(lines[r], form, c, coding, low, code[0][c], code[1][c]), error);
                keep(r, code, low, error, least, out);
            }
        }
    }
    /// Computes the lines that the codes stand for.
    template <int kRegions, int kChannels>
    static void linesOf(const Coded<kRegions, kChannels>& coded, const Coding& coding, Line* lines) {
        for (int r = 0; r < kRegions; ++r)
            for (int c = 0; c < kChannels; ++c) {
                lines[r].a[c] = valueOf(coded.code[2 * r][c], coding, coded.low[2 * r]);
                lines[r].b[c] = valueOf(coded.code[2 * r + 1][c], coding, coded.low[2 * r + 1]);
            }
    }

    /// Returns the number of choices of the low bits of a region.
    static int choicesOf(const Coding& coding) {
        return coding.lowBits == LowBits::PerEnd ? 4 : coding.lowBits == LowBits::PerRegion ? 2 : 1;
    }

private:
    /// The low bits of the ends of a region; below 0 in modes without them.
    struct LowPair {
        F first, second;
        LowPair(const Coding& coding, int choice) {
            const bool has = coding.lowBits != LowBits::None;
            first = set(has ? static_cast<float>(choice & 1) : -1.0f);
            second = coding.lowBits == LowBits::PerEnd ? set(static_cast<float>(choice >> 1)) : first;
        }
    };
    /// Ends that move by da and db add aa da^2 + 2 ab da db + bb db^2 to the squared error of a channel.
    struct Form {
        F aa, twiceAb, bb;
        F follows;  ///< the best db is -follows da
        explicit Form(const Line& line) {
            const F ab = line.k - line.kk;
            bb = line.kk;
            aa = line.n - line.k - ab;
            twiceAb = ab + ab;
            follows = ab / hn::Max(bb, set(1e-20f));
        }
    };
    /// Keeps codes of a region where their error is less.
    template <int kRegions, int kChannels>
    static HWY_INLINE void keep(int r, const F (&code)[2][kChannels], const LowPair& low, F error, F& least,
                                Coded<kRegions, kChannels>& out) {
        // The first codes are kept whatever their error, which may overflow.
        const auto better = hn::Or(error < least, least >= set(1e30f));
        least = hn::Min(error, least);
        out.low[2 * r] = hn::IfThenElse(better, hn::Max(low.first, zero()), out.low[2 * r]);
        out.low[2 * r + 1] = hn::IfThenElse(better, hn::Max(low.second, zero()), out.low[2 * r + 1]);
        for (int e = 0; e < 2; ++e)
            for (int c = 0; c < kChannels; ++c) out.code[2 * r + e][c] = hn::IfThenElse(better, code[e][c], out.code[2 * r + e][c]);
    }
    /// Rounds the ends of a channel. Returns what this adds to the error.
    static HWY_INLINE F roundPair(const Line& line, const Form& form, int channel, const Coding& coding, const LowPair& low, F& first,
                                  F& second) {
        const F a = line.a[channel], b = line.b[channel];
        const F largest = set(static_cast<float>((1 << coding.bits) - 1));
        F least = set(1e30f);
        const F below = clamp(hn::Floor(scaledCode(a, coding.bits, low.first)), zero(), largest);
        for (int side = 0; side < 2; ++side) {
            const F code = side == 0 ? below : hn::Min(below + set(1.0f), largest);
            const F da = valueOf(code, coding, low.first) - a;
            const F other = nearestCode(hn::NegMulAdd(da, form.follows, b), coding.bits, low.second);
            const F db = valueOf(other, coding, low.second) - b;
            const F error = hn::MulAdd(form.aa * da, da, hn::MulAdd(form.bb, db, form.twiceAb * da) * db);
            const auto better = error < least;
            least = hn::Min(error, least);
            first = side == 0 ? code : hn::IfThenElse(better, code, first);
            second = side == 0 ? other : hn::IfThenElse(better, other, second);
        }
        return least;
    }
    /// Expands a value to eight bits: the high bits are repeated below.
    static HWY_INLINE F expand(F value, int bits) {
        if (bits == 8) return value;
        return value * set(static_cast<float>(1 << (8 - bits))) + hn::Floor(value * set(1.0f / static_cast<float>(1 << (2 * bits - 8))));
    }
    /// Returns the code that stands for a value in 0 .. 255, not rounded, given its low bit; low < 0: the mode has none.
    static HWY_INLINE F scaledCode(F value, int bits, F low) {
        const bool hasLow = hn::GetLane(low) >= 0;
        const F scaled = value * set(static_cast<float>((1 << (bits + hasLow)) - 1) / 255.0f);
        return hasLow ? (scaled - low) * set(0.5f) : scaled;
    }
    static HWY_INLINE F nearestCode(F value, int bits, F low) {
        return hn::Round(clamp(scaledCode(value, bits, low), zero(), set(static_cast<float>((1 << bits) - 1))));
    }
    static HWY_INLINE F valueOf(F code, const Coding& coding, F low) {
        if (coding.lowBits == LowBits::None) return expand(code, coding.bits);
        return expand(code * set(2.0f) + low, coding.bits + 1);
    }
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
