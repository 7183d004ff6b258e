// BC1: the indices of blocks for known endpoints, and their bytes: two endpoints of 16 bits, then sixteen indices of two bits.
// In BC1 the order of the endpoints selects the mode: first > second means four colours, else three. BC3 has four colours whatever the
// order.
#if defined(LIGHTCOOK_COMPRESS_BC1_PACK_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC1_PACK_INL_H_
#undef LIGHTCOOK_COMPRESS_BC1_PACK_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC1_PACK_INL_H_
#endif

#include <hwy/highway.h>

#include <cstdint>

#include "compress/bc1/search.h"
#include "compress/bc1/texels-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D>
class Bc1Packer : Lanes<D> {
    using typename Lanes<D>::F, typename Lanes<D>::M, typename Lanes<D>::DU, typename Lanes<D>::U;
    using Lanes<D>::set, Lanes<D>::zero, Lanes<D>::clamp;

public:
    /// isThree           lanes of the three-colour mode
    /// orderSelectsMode  true in BC1, false in BC3
    Bc1Packer(const Bc1Texels<D>& texels, const Bc1Candidate<D>& best, M isThree, bool orderSelectsMode)
        : texels_(texels), best_(best), isThree_(isThree), orderSelectsMode_(orderSelectsMode) {}

    /// Packs the blocks into two words each.
    void pack(U& ends, U& indices) const {
        const DU du;
        const U one = packed565(best_.code[0]), two = packed565(best_.code[1]), odd = hn::Set(du, 0x55555555);
        U first = one, second = two;
        const U steps = stepsOfTexels();
        U low = hn::And(steps, odd), high = hn::And(hn::ShiftRight<1>(steps), odd);
        const auto isThree = hn::RebindMask(du, isThree_);
        if (orderSelectsMode_) {
            const U larger = hn::Max(one, two), smaller = hn::Min(one, two);
            first = hn::IfThenElse(isThree, smaller, larger);
            second = hn::IfThenElse(isThree, larger, smaller);
            // Swapped ends mirror the steps: 3 - k inverts both bits, 2 - k swaps 0 and 2.
            const auto swapped = first != one;
            const U mirroredHigh = hn::IfThenElse(isThree, hn::AndNot(hn::Or(low, high), odd), hn::AndNot(high, odd));
            const U mirroredLow = hn::IfThenElse(isThree, low, hn::AndNot(low, odd));
            low = hn::IfThenElse(swapped, mirroredLow, low);
            high = hn::IfThenElse(swapped, mirroredHigh, high);
        }
        // Index 0 is the first endpoint, 1 the second; 2 and 3 are the colours between them.
        const U between = hn::IfThenElse(isThree, low, hn::Xor(low, high));
        // Equal endpoints select three colours, but then all indices below 3 are the same colour.
        indices = hn::IfThenElseZero(one != two, hn::Or(hn::ShiftLeft<1>(between), high));
        ends = hn::Or(first, hn::ShiftLeft<16>(second));
    }

    /// Writes the endpoints as results, one after the other.
    void store(Bc1Result* found) const {
        const D d;
        HWY_ALIGN float buffer[hn::MaxLanes(D())];
        const std::size_t lanes = hn::Lanes(d);
        for (std::size_t e = 0; e < 2; ++e)
            for (std::size_t c = 0; c < 3; ++c) {
                hn::Store(best_.code[e][c], d, buffer);
                for (std::size_t lane = 0; lane < lanes; ++lane)
                    (e ? found[lane].second : found[lane].first)[c] = static_cast<std::uint8_t>(buffer[lane]);
            }
        hn::Store(hn::IfThenElseZero(isThree_, set(1.0f)), d, buffer);
        for (std::size_t lane = 0; lane < lanes; ++lane) found[lane].threeColours = buffer[lane] != 0;
    }

private:
    static U packed565(const F (&code)[3]) {
        // Exact in floats: below 2^16.
        const F packed = hn::MulAdd(code[0], set(2048.0f), hn::MulAdd(code[1], set(32.0f), code[2]));
        return hn::BitCast(DU(), hn::ConvertTo(hn::RebindToSigned<D>(), packed));
    }

    /// Returns the step of each texel from the first endpoint, two bits each.
    U stepsOfTexels() const {
        const F last = hn::IfThenElse(isThree_, set(2.0f), set(3.0f));
        const auto places = texels_.placesOf(best_, last);
        // Eight texels make a float below 2^16, which is exact.
        const auto half = [&](std::size_t first) {
            F sum = zero();
            for (std::size_t t = first + kTexelCount / 2; t-- > first;)
                sum = hn::MulAdd(sum, set(4.0f), hn::Round(clamp(texels_.placeOf(places, t), zero(), last)));
            return hn::BitCast(DU(), hn::ConvertTo(hn::RebindToSigned<D>(), sum));
        };
        return hn::Or(half(0), hn::ShiftLeft<16>(half(kTexelCount / 2)));
    }

    const Bc1Texels<D>& texels_;
    const Bc1Candidate<D>& best_;
    const M isThree_;
    const bool orderSelectsMode_;
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
