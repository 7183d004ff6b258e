// Two 16-bit integers in each lane of floats, for kernels that keep two texels of a block in its lane.
#if defined(LIGHTCOOK_COMPRESS_PAIRS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_PAIRS_INL_H_
#undef LIGHTCOOK_COMPRESS_PAIRS_INL_H_
#else
#define LIGHTCOOK_COMPRESS_PAIRS_INL_H_
#endif

#include <hwy/highway.h>

#include <cstddef>
#include <cstdint>

#include "compress/block/block.h"
#include "compress/block/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D>
struct Pairs : Lanes<D> {
    using typename Lanes<D>::F, typename Lanes<D>::DI, typename Lanes<D>::I;
    using DS = hn::Repartition<std::int16_t, D>;
    using S = hn::Vec<DS>;
    static constexpr std::size_t kPairs = kTexelCount / 2;

    static HWY_INLINE S setBoth(int value) { return hn::Set(DS(), static_cast<std::int16_t>(value)); }
    /// Returns integers whose 16 low bits are those of the rounded value, which may be negative.
    static HWY_INLINE I lowBitsOf(F value) { return hn::BitCast(DI(), value + Lanes<D>::set(0x1.8p23f)); }
    /// Returns integers whose even lanes are the low halves of a, and whose odd lanes those of b.
    static HWY_INLINE S inPairs(I a, I b) { return hn::OddEven(hn::BitCast(DS(), hn::ShiftLeft<16>(b)), hn::BitCast(DS(), a)); }
    static HWY_INLINE S inBoth(I a) { return inPairs(a, a); }

    /// Returns a[2 i] b[2 i] + a[2 i + 1] b[2 i + 1].
    static HWY_INLINE I mulPairs(S a, S b) {
        const DI di;
#if HWY_ARCH_X86
        I unused = hn::Zero(di);
        return hn::ReorderWidenMulAccumulate(di, a, b, hn::Zero(di), unused);
#else
        const auto even = [&](S v) { return hn::ShiftRight<16>(hn::ShiftLeft<16>(hn::BitCast(di, v))); };
        const auto odd = [&](S v) { return hn::ShiftRight<16>(hn::BitCast(di, v)); };
        return even(a) * even(b) + odd(a) * odd(b);
#endif
    }
    /// Returns the sum of the products of eight pairs.
    static HWY_INLINE I dot(const S (&a)[kPairs], const S (&b)[kPairs]) {
        I sum = mulPairs(a[0], b[0]);
        for (std::size_t pair = 1; pair < kPairs; ++pair) sum = sum + mulPairs(a[pair], b[pair]);
        return sum;
    }
    /// Returns the sum of eight pairs.
    static HWY_INLINE I sumOf(const S (&a)[kPairs]) {
        I sum = mulPairs(a[0], setBoth(1));
        for (std::size_t pair = 1; pair < kPairs; ++pair) sum = sum + mulPairs(a[pair], setBoth(1));
        return sum;
    }
    /// Returns the sum of eight pairs whose partial sums fit into 16 bits.
    static HWY_INLINE I smallSumOf(const S (&a)[kPairs]) {
        S sum = a[0];
        for (std::size_t pair = 1; pair < kPairs; ++pair) sum = sum + a[pair];
        return mulPairs(sum, setBoth(1));
    }
    /// Returns the smaller or larger element of each pair, in both.
    static HWY_INLINE S minInBoth(S a) {
        return hn::Min(a, swapped(a));
    }
    static HWY_INLINE S maxInBoth(S a) {
        return hn::Max(a, swapped(a));
    }

private:
    static HWY_INLINE S swapped(S a) {
        const hn::RebindToUnsigned<DI> du;
        const auto bits = hn::BitCast(du, a);
        return hn::BitCast(DS(), hn::Or(hn::ShiftLeft<16>(bits), hn::ShiftRight<16>(bits)));
    }
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
