// BC4: the indices of a block for known endpoints, and its bytes: two endpoints, then sixteen indices of three bits.
// The order of the endpoints selects the mode: first > second means eight values, else six values and the two extremes.
#if defined(LIGHTCOOK_COMPRESS_BC4_PACK_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC4_PACK_INL_H_
#undef LIGHTCOOK_COMPRESS_BC4_PACK_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC4_PACK_INL_H_
#endif

#include <hwy/highway.h>

#include <cstdint>

#include "compress/bc4/search.h"
#include "compress/bc4/texels-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D>
class Bc4Packer : Lanes<D> {
    using typename Lanes<D>::F, typename Lanes<D>::M, typename Lanes<D>::DI, typename Lanes<D>::DU, typename Lanes<D>::U;
    using Lanes<D>::set, Lanes<D>::clamp;
    using Candidate = Bc4Candidate<D>;

public:
    /// isSix  lanes of the six-value mode
    Bc4Packer(const Bc4Texels<D>& texels, const Candidate& best, M isSix) : texels_(texels), best_(best), isSix_(isSix) {}

    /// Packs the blocks into two words each.
    void pack(U& lowWord, U& highWord) const {
        const DI di;
        const DU du;
        const auto byteOf = [&](F code) { return hn::And(hn::ConvertTo(di, code - set(texels_.codes().offset)), hn::Set(di, 0xff)); };
        const F first = hn::IfThenElse(isSix_, best_.low, best_.high), second = hn::IfThenElse(isSix_, best_.high, best_.low);
        const auto ends = hn::Or(byteOf(first), hn::ShiftLeft<8>(byteOf(second)));
        const auto front = indicesFrom(0), back = indicesFrom(kTexelCount / 2);
        lowWord = hn::BitCast(du, hn::Or(ends, hn::ShiftLeft<16>(front)));
        highWord = hn::BitCast(du, hn::Or(hn::ShiftRight<16>(front), hn::ShiftLeft<8>(back)));
    }

    /// Writes the blocks as results, one after the other.
    void store(Bc4Result* found) const {
        const D d;
        const DI di;
        HWY_ALIGN float error[hn::MaxLanes(D())];
        HWY_ALIGN std::int32_t words[6][hn::MaxLanes(D())];
        hn::Store(best_.error, d, error);
        hn::Store(hn::ConvertTo(di, best_.low), di, words[0]);
        hn::Store(hn::ConvertTo(di, best_.high), di, words[1]);
        hn::Store(hn::ConvertTo(di, hn::IfThenElseZero(isSix_, set(1.0f))), di, words[2]);
        hn::Store(hn::ConvertTo(di, hn::IfThenElseZero(texels_.lowest >= texels_.highest, set(1.0f))), di, words[3]);
        hn::Store(indicesFrom(0), di, words[4]);
        hn::Store(indicesFrom(kTexelCount / 2), di, words[5]);
        for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) {
            const auto half = [&](std::size_t which) { return static_cast<std::uint64_t>(words[which][lane]); };
            found[lane] = {words[0][lane], words[1][lane], words[2][lane] != 0, error[lane], half(4) | half(5) << 24, words[3][lane] != 0};
        }
    }

private:
    /// Returns the indices of the eight texels from `first` on, three bits each. Index 0 is the first endpoint, index 1 the second; 2 and
    /// up are the entries between them; in the six-value mode 6 is the smallest and 7 the largest code.
    hn::Vec<DI> indicesFrom(std::size_t first) const {
        const DI di;
        const bool someSix = !hn::AllFalse(D(), isSix_);
        const auto steps = someSix ? stepsFrom<true>(first) : stepsFrom<false>(first);
        const auto field = hn::Set(di, 0x249249), all = hn::Set(di, 0xffffff);
        const auto isSix = hn::RebindMask(di, isSix_);
        // Steps count from the low endpoint, which is the second one in the eight-value mode: 7 - k inverts all bits.
        const auto k = hn::IfThenElse(isSix, steps, hn::Xor(steps, all));
        const auto k0 = hn::And(k, field), k1 = hn::And(hn::ShiftRight<1>(k), field), k2 = hn::And(hn::ShiftRight<2>(k), field);
        // The index of step k is k + 1, modulo 8, apart from the ends: 0 and the last one differ in the lowest bit. In the six-value mode
        // the last one is 5, and 6 and 7 stay: 5 and 7 differ in all bits, 6 in the lowest.
        const auto isZero = hn::AndNot(hn::Or(k0, hn::Or(k1, k2)), field);
        const auto isLast = hn::IfThenElse(isSix, hn::And(k2, hn::Or(k0, k1)), hn::And(k0, hn::And(k1, k2)));
        const auto isOdd = hn::IfThenElseZero(isSix, hn::And(k2, k0));
        const auto bit0 = hn::Xor(hn::AndNot(k0, field), hn::Or(isZero, isLast));
        const auto bit1 = hn::Xor(hn::Xor(k0, k1), isOdd), bit2 = hn::Xor(hn::Xor(hn::And(k0, k1), k2), isOdd);
        return hn::Or(bit0, hn::Or(hn::ShiftLeft<1>(bit1), hn::ShiftLeft<2>(bit2)));
    }

    /// Returns the steps of the eight texels from `first` on, three bits each; in the six-value mode 6 and 7 are the extremes.
    template <bool kSomeSix>
    hn::Vec<DI> stepsFrom(std::size_t first) const {
        const F steps = kSomeSix ? hn::IfThenElse(isSix_, set(5.0f), set(7.0f)) : set(7.0f), range = best_.high - best_.low;
        const F scale = steps / hn::Max(range, set(0.5f));
        // Eight steps make a float below 2^24, which is exact.
        F sum = set(0.0f);
        for (std::size_t t = first + kTexelCount / 2; t-- > first;) {
            const F above = texels_.value[t] - best_.low;
            F step = hn::Round(clamp(above * scale, set(0.0f), steps));
            if constexpr (kSomeSix) {
                const F miss = hn::Abs(hn::NegMulAdd(step, range / steps, above)), fromLargest = texels_.largest() - texels_.value[t];
                const M nearZero = hn::And(isSix_, texels_.value[t] < miss);
                const M nearLargest = hn::And(isSix_, hn::And(fromLargest < miss, fromLargest < texels_.value[t]));
                step = hn::IfThenElse(nearLargest, set(7.0f), hn::IfThenElse(nearZero, set(6.0f), step));
            }
            sum = hn::MulAdd(sum, set(8.0f), step);
        }
        return hn::ConvertTo(DI(), sum);
    }

    const Bc4Texels<D>& texels_;
    const Candidate& best_;
    const M isSix_;
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
