// Names shared by all kernels: the types of a vector of floats, and arithmetic on its lanes.
//
// A kernel works on as many blocks as a vector has lanes, one block a lane. No operation mixes lanes, and every operation is a plain IEEE
// operation, so a block gets the same bits at any vector width.
#if defined(LIGHTCOOK_COMPRESS_LANES_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_LANES_INL_H_
#undef LIGHTCOOK_COMPRESS_LANES_INL_H_
#else
#define LIGHTCOOK_COMPRESS_LANES_INL_H_
#endif

#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// Base of the kernels' classes. D is a Highway tag of floats.
template <class D>
struct Lanes {
    using F = hn::Vec<D>;
    using M = hn::Mask<D>;
    using DI = hn::RebindToSigned<D>;
    using I = hn::Vec<DI>;
    using DU = hn::RebindToUnsigned<D>;
    using U = hn::Vec<DU>;
    static constexpr std::size_t kMaxLanes = hn::MaxLanes(D());

    static HWY_INLINE F set(float value) { return hn::Set(D(), value); }
    static HWY_INLINE F zero() { return hn::Zero(D()); }
    static HWY_INLINE F clamp(F value, F low, F high) { return hn::Min(hn::Max(value, low), high); }
    static HWY_INLINE F select(M mask, F yes, F no) { return hn::IfThenElse(mask, yes, no); }
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
