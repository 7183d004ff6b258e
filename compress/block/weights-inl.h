// Weights of texels in sums over a block, for kernels that are compiled twice: once for weights of 1, which most blocks have.
#if defined(LIGHTCOOK_COMPRESS_WEIGHTS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_WEIGHTS_INL_H_
#undef LIGHTCOOK_COMPRESS_WEIGHTS_INL_H_
#else
#define LIGHTCOOK_COMPRESS_WEIGHTS_INL_H_
#endif

#include <hwy/highway.h>

#include <cstddef>

#include "compress/block/block.h"
#include "compress/block/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Weights of 1: saves the products of TexelWeights and gives the same bits.
template <class D>
struct UnitWeights {
    using F = hn::Vec<D>;
    HWY_INLINE F times(std::size_t, F x) const { return x; }
    HWY_INLINE F ifCounts(std::size_t, F yes, F) const { return yes; }
};

/// One weight for each texel.
template <class D>
struct TexelWeights {
    using F = hn::Vec<D>;
    const F* weight;
    HWY_INLINE F times(std::size_t t, F x) const { return weight[t] * x; }
    HWY_INLINE F ifCounts(std::size_t t, F yes, F no) const { return hn::IfThenElse(weight[t] > hn::Zero(D()), yes, no); }
};

/// Returns true if the weight of every texel in every lane is 1.
template <class D>
bool areUnitWeights(D d, const hn::Vec<D> (&weight)[kTexelCount]) {
    hn::Mask<D> isOne = weight[0] == hn::Set(d, 1.0f);
    for (std::size_t t = 1; t < kTexelCount; ++t) isOne = hn::And(isOne, weight[t] == hn::Set(d, 1.0f));
    return hn::AllTrue(d, isOne);
}

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
