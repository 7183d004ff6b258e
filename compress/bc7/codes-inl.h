// BC7: rounds the ends of lines to codes of a mode, with their low bits, and converts codes back to values.
#if defined(LIGHTCOOK_COMPRESS_BC7_CODES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC7_CODES_INL_H_
#undef LIGHTCOOK_COMPRESS_BC7_CODES_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC7_CODES_INL_H_
#endif

#include <hwy/highway.h>

#include "compress/bc7/lines-inl.h"
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

/// Rounded ends, the indices of the texels, and the error.
template <class D, int kEnds, int kChannels>
struct Bc7Coded {
    hn::Vec<D> error;
    hn::Vec<D> code[kEnds][kChannels], low[kEnds];
    hn::Vec<D> index[kTexelCount];
};

template <class D>
class Bc7Codes : Lanes<D> {
    using typename Lanes<D>::F;
    using Lanes<D>::set, Lanes<D>::zero, Lanes<D>::clamp;
    using View = Bc7View<D>;
    using Line = Bc7Line<D>;
    using Coding = Bc7Coding;
    using LowBits = Bc7LowBits;
    template <int kEnds, int kChannels>
    using Coded = Bc7Coded<D, kEnds, kChannels>;

public:
    /// Rounds ends to codes.
    /// forced  low bits to use, one bit for each end or region; -1 chooses the nearest
    template <int kRegions, int kChannels>
    static void codesOf(const View& view, const Line* lines, const Coding& coding, int forced, Coded<2 * kRegions, kChannels>& out) {
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
    /// Computes the lines that the codes stand for.
    template <int kRegions, int kChannels>
    static void linesOf(const Coded<2 * kRegions, kChannels>& coded, const Coding& coding, Line* lines) {
        for (int r = 0; r < kRegions; ++r)
            for (int c = 0; c < kChannels; ++c) {
                lines[r].a[c] = valueOf(coded.code[2 * r][c], coding, coded.low[2 * r]);
                lines[r].b[c] = valueOf(coded.code[2 * r + 1][c], coding, coded.low[2 * r + 1]);
            }
    }

private:
    /// Expands a value to eight bits: the high bits are repeated below.
    static HWY_INLINE F expand(F value, int bits) {
        if (bits == 8) return value;
        return value * set(static_cast<float>(1 << (8 - bits))) + hn::Floor(value * set(1.0f / static_cast<float>(1 << (2 * bits - 8))));
    }
    /// Returns the code nearest to a value in 0 .. 255, given its low bit; low < 0: the mode has none.
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

    /// Returns the low bit that puts an end, or both ends if they share it, closer to its unrounded value.
    template <int kChannels>
    static F nearestLowBit(const View& view, const Line& line, const Coding& coding, int which) {
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
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
