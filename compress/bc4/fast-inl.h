// The fast kernel of BC4, BC5 and BC3's alpha, for effort 0: the eight-value mode of blocks whose texels all weigh 1, in 16-bit integers.
// One block in each lane of floats, two texels in each lane of integers.
//
// 1. Each texel becomes its position in the range of the block, 0 .. kLast: fine enough that its rounding does not show in the error.
// 2. Each start (kBc4Starts) is a pair of ends that are fixed shares of the range. So the step k of a texel is its position times a
//    constant plus a constant, shifted: the sums of k, k^2 and k p need no division and no clamp.
// 3. The least-squares ends of a start follow from its sums in floats and are rounded to codes, as in ends-inl.h. The start with the least
//    error is kept. The squares of the positions are the same for all starts and are left out.
// 4. The indices are the nearest steps between the codes.
//
// Integers and plain operations on floats only: a block gets the same bytes at any vector width.
#if defined(LIGHTCOOK_COMPRESS_BC4_FAST_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC4_FAST_INL_H_
#undef LIGHTCOOK_COMPRESS_BC4_FAST_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC4_FAST_INL_H_
#endif

#include <hwy/highway.h>

#include <array>
#include <cstddef>
#include <cstdint>

#include "compress/bc4/search.h"
#include "compress/block/block.h"
#include "compress/block/pairs-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D>
class Bc4Fast : Pairs<D> {
    using typename Pairs<D>::F, typename Pairs<D>::M, typename Pairs<D>::DI, typename Pairs<D>::I, typename Pairs<D>::DU,
        typename Pairs<D>::U, typename Pairs<D>::DS, typename Pairs<D>::S;
    using Pairs<D>::set, Pairs<D>::clamp, Pairs<D>::kPairs, Pairs<D>::lowBitsOf, Pairs<D>::inPairs, Pairs<D>::inBoth, Pairs<D>::mulPairs;

public:
    /// Blocks whose endpoints are known. pack() is a call of its own, so that the caller can do other work between the two: the endpoints
    /// take long to compute, though few operations.
    struct Fitted {
        S place[kPairs];  ///< positions of texels t and t + 4, rows 0 and 1 first
        F lowest, unit;   ///< value in codes of position 0, and codes per position
        F low, high;      ///< endpoints
    };

    explicit Bc4Fast(const Bc4Codes& codes) : codes_(codes) {}

    /// Finds the endpoints of Lanes(d) blocks.
    /// value            sixteen texels in the range of the format
    /// lowest, highest  the range of each block
    HWY_INLINE void fit(const F* value, F lowest, F highest, Fitted& out) const {
        const F range = highest - lowest, perRange = set(kLast) / hn::Max(range, set(1e-30f));
        I sumPlaces = hn::Zero(DI());
        for (std::size_t pair = 0; pair < kPairs; ++pair) {
            const std::size_t t = pair / 4 * 8 + pair % 4;
            const I front = placeOf(value[t] - lowest, perRange), back = placeOf(value[t + 4] - lowest, perRange);
            out.place[pair] = inPairs(front, back);
            sumPlaces = sumPlaces + mulPairs(out.place[pair], hn::Set(DS(), 1));
        }
        out.lowest = hn::MulAdd(lowest, set(codes_.scale), set(codes_.offset));
        out.unit = range * set(codes_.scale / kLast);
        Means means;
        means.place = hn::ConvertTo(D(), sumPlaces) * set(1.0f / kTexelCount);
        means.value = hn::MulAdd(out.unit, means.place, out.lowest);
        F sumK[kStarts], sumKk[kStarts], sumKp[kStarts];
        sumSteps<0>(out.place, sumK, sumKk, sumKp);
        sumSteps<1>(out.place, sumK, sumKk, sumKp);
        sumSteps<2>(out.place, sumK, sumKk, sumKp);
        Ends best = {set(1e30f), set(0.0f), set(1.0f)};
        for (int start = 0; start < kStarts; ++start) choose(means, out.unit, sumK[start], sumKk[start], sumKp[start], best);
        out.low = best.low;
        out.high = best.high;
    }

    /// Returns the low and the high word of each block.
    HWY_INLINE void pack(const Fitted& fitted, U& lowWord, U& highWord) const {
        // Steps in units of 1024: positions times a factor, plus an offset.
        constexpr float kStep = 1024;
        const DS ds;
        const F perCode = set(7 * kStep) / (fitted.high - fitted.low);
        const S factor = inBoth(lowBitsOf(hn::Min(fitted.unit * set(32768.0f) * perCode, set(32767.0f))));
        const S offset =
            inBoth(lowBitsOf(clamp(hn::MulAdd(fitted.lowest - fitted.low, perCode, set(kStep / 2)), set(-32767.0f), set(32767.0f))));
        S step[kPairs];
        for (std::size_t pair = 0; pair < kPairs; ++pair) {
            const S at = hn::SaturatedAdd(hn::MulFixedPoint15(fitted.place[pair], factor), offset);
            step[pair] = hn::ShiftRight<10>(hn::Min(hn::Max(at, hn::Zero(ds)), hn::Set(ds, static_cast<std::int16_t>(8 * kStep - 1))));
        }
        joinWords(fitted.high, fitted.low, indicesOf(step), indicesOf(step + 4), lowWord, highWord);
        const M isConstant = fitted.unit <= set(0.0f);
        if (!hn::AllFalse(D(), isConstant)) packConstant(fitted.lowest, isConstant, lowWord, highWord);
    }

    /// Encodes the blocks whose weights are all 1, and leaves the words of the others.
    /// value, lowest, highest  see fit()
    HWY_NOINLINE void replaceUnweighted(const F* value, F lowest, F highest, const F (&weight)[kTexelCount], U& lowWord,
                                        U& highWord) const {
        M isOne = weight[0] == set(1.0f);
        for (const F w : weight) isOne = hn::And(isOne, w == set(1.0f));
        if (hn::AllFalse(D(), isOne)) return;
        Fitted fitted;
        U low, high;
        fit(value, lowest, highest, fitted);
        pack(fitted, low, high);
        const auto mask = hn::RebindMask(DU(), isOne);
        lowWord = hn::IfThenElse(mask, low, lowWord);
        highWord = hn::IfThenElse(mask, high, highWord);
    }

private:
    static constexpr int kStarts = 3;
    static constexpr float kUnit = 4096;  ///< positions to a step, in the start with the shortest steps
    /// The position of the highest texel: seven steps of start 1, whose steps are the shortest.
    static constexpr float kLast = 31165;

    /// The steps of a start: (position * factor + offset) / kUnit, rounded down.
    struct Start {
        double factor, offset;
        constexpr explicit Start(std::size_t index) {
            const double in = kBc4Starts[index][0], out = kBc4Starts[index][1], perLength = 1 / (1 - in - out);
            factor = perLength * 7 * kUnit / kLast;
            offset = (0.5 - in * perLength * 7) * kUnit;
        }
        constexpr bool needsNoClamp() const { return offset >= 0 && factor * kLast + offset < 8 * kUnit - 2; }
    };

    struct Ends {
        F error, low, high;  ///< error: without the squared distances from the mean
    };
    /// Means of a block: of the positions, and of the values in codes.
    struct Means {
        F place, value;
    };

    /// Returns integers whose 16 low bits are the rounded position.
    static HWY_INLINE I placeOf(F above, F perRange) { return hn::BitCast(DI(), hn::MulAdd(above, perRange, set(0x1p23f))); }
    /// Assigns each texel its step k in a start, and sums k, k^2 and k p, p the position.
    template <int kIndex>
    static HWY_INLINE void sumSteps(const S* places, F* sumK, F* sumKk, F* sumKp) {
        constexpr Start kStart(kIndex);
        static_assert(kStart.needsNoClamp());
        const DS ds;
        S k1 = hn::Zero(ds), k2 = k1;
        I kp = hn::Zero(DI());
        for (std::size_t pair = 0; pair < kPairs; ++pair) {
            S at = places[pair];
            if constexpr (kIndex != 1) at = hn::MulFixedPoint15(at, hn::Set(ds, static_cast<std::int16_t>(kStart.factor * 32768 + 0.5)));
            const S k = hn::ShiftRight<12>(at + hn::Set(ds, static_cast<std::int16_t>(kStart.offset + 0.5)));
            k1 = k1 + k;
            k2 = k2 + k * k;
            kp = kp + mulPairs(k, places[pair]);
        }
        const auto total = [&](S sum) { return hn::ConvertTo(D(), mulPairs(sum, hn::Set(ds, 1))); };
        sumK[kIndex] = total(k1);
        sumKk[kIndex] = total(k2);
        sumKp[kIndex] = hn::ConvertTo(D(), kp);
    }

    /// Solves the least-squares ends for the sums of k, k^2 and k p, rounds them to codes and keeps them where they are better.
    HWY_INLINE void choose(const Means& means, F unit, F sumK, F sumKk, F sumKp, Ends& best) const {
        const F meanK = sumK * set(1.0f / kTexelCount);
        const F kk = hn::NegMulAdd(meanK, sumK, sumKk), kv = hn::NegMulAdd(sumK, means.place, sumKp) * unit;
        const F inverse = set(1.0f) / hn::Max(kk * sumKk, set(1e-6f));
        const F slope = kv * (inverse * sumKk);
        const F lowBest = hn::NegMulAdd(slope, meanK, means.value), highBest = hn::MulAdd(set(7.0f), slope, lowBest);
        const F low = hn::Round(clamp(lowBest, set(0.0f), set(codes_.largest - 1)));
        const F off = low - lowBest;
        // The best high end for the rounded low one.
        const F follow = hn::NegMulAdd(sumK * set(7.0f), inverse * kk, set(1.0f));
        const F high = hn::Max(hn::Round(hn::Min(hn::MulAdd(off, follow, highBest), set(codes_.largest))), low + set(1.0f));
        const F steeper = hn::MulSub(high - low, set(1.0f / 7), slope);
        const F more = hn::MulAdd(off * off, set(kTexelCount), steeper * hn::MulAdd(sumKk, steeper, (sumK + sumK) * off));
        const F error = hn::NegMulAdd(slope, kv, more);
        const M better = error < best.error;
        best.error = hn::IfThenElse(better, error, best.error);
        best.low = hn::IfThenElse(better, low, best.low);
        best.high = hn::IfThenElse(better, high, best.high);
    }

    /// Returns the indices of eight texels, three bits each, for the steps from the second endpoint.
    static HWY_INLINE I indicesOf(const S* step) {
        const S row = hn::Or(hn::Or(step[0], hn::ShiftLeft<3>(step[1])), hn::Or(hn::ShiftLeft<6>(step[2]), hn::ShiftLeft<9>(step[3])));
        return indicesOf(mulPairs(row, inPairs(hn::Set(DI(), 1), hn::Set(DI(), 4096))));
    }
    /// The index of step k is 8 - k, modulo 8, but 1 for 0 and 0 for 7: in bits, counted from the lowest,
    /// k0 ^ (all bits are equal), k1 ^ k0, k2 ^ (k1 | k0).
    static HWY_INLINE I indicesOf(I k) {
        const DI di;
        const I bit0 = hn::Set(di, 0x249249), bit2 = hn::Set(di, 0x924924), bits12 = hn::Set(di, 0xDB6DB6);
        const I differs = hn::Xor(k, hn::ShiftRight<1>(k));
        const I unequal = hn::Or(differs, hn::ShiftRight<1>(differs));
        const I upper = hn::Or(hn::And(hn::ShiftLeft<1>(k), bits12), hn::And(hn::ShiftLeft<2>(k), bit2));
        return hn::Xor(k, hn::Or(upper, hn::AndNot(unequal, bit0)));
    }

    /// Joins two endpoints in codes and the indices of the front and the back half of the texels.
    HWY_INLINE void joinWords(F first, F second, I front, I back, U& lowWord, U& highWord) const {
        const DI di;
        // Signed bytes: code - 127 is code + 1 with the highest bit flipped.
        const bool isSigned = codes_.offset != 0;
        const F both = hn::MulAdd(second, set(256.0f), first + set(isSigned ? 0x0101 : 0));
        const I ends = hn::Xor(lowBitsOf(both), hn::Set(di, isSigned ? 0x8080 : 0));
        lowWord = hn::BitCast(DU(), inPairs(ends, front));
        highWord = hn::BitCast(DU(), hn::Or(hn::ShiftRight<16>(front), hn::ShiftLeft<8>(back)));
    }

    /// Packs blocks of one value: two neighbouring codes, with the sevenths or the fifths of a code between them.
    void packConstant(F value, M isConstant, U& lowWord, U& highWord) const {
        const DI di;
        const auto fitTo = [&](float steps, F& low, F& step) {
            const F rounded = hn::Round(value * set(steps));
            low = hn::Min(hn::Floor(rounded / set(steps)), set(codes_.largest - 1));
            step = hn::NegMulAdd(low, set(steps), rounded);
            return hn::Abs(hn::NegMulAdd(rounded, set(1 / steps), value));
        };
        F low7, step7, low5, step5;
        const F miss7 = fitTo(7, low7, step7), miss5 = fitTo(5, low5, step5);
        const M isSix = miss5 < miss7;
        // In the six-value mode the first end is the lower one, and index 1 is the last step.
        const I index6 =
            hn::NearestInt(hn::IfThenElse(step5 == set(0.0f), set(0.0f), hn::IfThenElse(step5 == set(5.0f), set(1.0f), step5 + set(1.0f))));
        const I index8 = hn::And(indicesOf(hn::NearestInt(step7)), hn::Set(di, 7));
        const I index = hn::IfThenElse(hn::RebindMask(di, isSix), index6, index8);
        const I indices = index * hn::Set(di, 0x249249);
        const F one = set(1.0f);
        U low, high;
        joinWords(hn::IfThenElse(isSix, low5, low7 + one), hn::IfThenElse(isSix, low5 + one, low7), indices, indices, low, high);
        const auto mask = hn::RebindMask(DU(), isConstant);
        lowWord = hn::IfThenElse(mask, low, lowWord);
        highWord = hn::IfThenElse(mask, high, highWord);
    }

    const Bc4Codes codes_;
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
