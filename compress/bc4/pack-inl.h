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
        const F steps = hn::IfThenElse(isSix_, set(5.0f), set(7.0f)), range = best_.high - best_.low;
        const F scale = steps / hn::Max(range, set(0.5f)), unit = range / steps;
        auto bits = hn::Zero(di);
        for (std::size_t t = first + kTexelCount / 2; t-- > first;) {
            const F above = texels_.value[t] - best_.low;
            const F step = hn::Round(clamp(above * scale, set(0.0f), steps));
            const F miss = hn::Abs(hn::NegMulAdd(step, unit, above)), fromLargest = texels_.largest() - texels_.value[t];
            const F fromFirst = hn::IfThenElse(isSix_, step, steps - step);
            F index =
                hn::IfThenElse(fromFirst == set(0.0f), fromFirst, hn::IfThenElse(fromFirst == steps, set(1.0f), fromFirst + set(1.0f)));
            index = hn::IfThenElse(hn::And(isSix_, texels_.value[t] < miss), set(6.0f), index);
            index = hn::IfThenElse(hn::And(isSix_, hn::And(fromLargest < miss, fromLargest < texels_.value[t])), set(7.0f), index);
            bits = hn::Or(hn::ShiftLeft<3>(bits), hn::ConvertTo(di, index));
        }
        return bits;
    }

    const Bc4Texels<D>& texels_;
    const Candidate& best_;
    const M isSix_;
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
