// BC7, closed forms: the plane through the texels of a block that holds most of their variance, in which partitions are ranked.
#if defined(LIGHTCOOK_COMPRESS_BC7_CLOSED_FORM_PLANE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC7_CLOSED_FORM_PLANE_INL_H_
#undef LIGHTCOOK_COMPRESS_BC7_CLOSED_FORM_PLANE_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC7_CLOSED_FORM_PLANE_INL_H_
#endif

#include <hwy/highway.h>

#include <cstddef>

#include "compress/bc7/closed_form/least_squares-inl.h"
#include "compress/bc7/closed_form/region_fit-inl.h"
#include "compress/bc7/closed_form/texels-inl.h"
#include "compress/block/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D>
class Bc7Plane : Lanes<D> {
    using typename Lanes<D>::F, typename Lanes<D>::DI;
    using Lanes<D>::zero;

public:
    F p[kTexelCount], q[kTexelCount];  ///< positions of the texels on the two principal axes, about their mean
    F outside;                         ///< variance outside the plane, times the weight of the block

    /// whole       the block as one region, started
    /// product     see Bc7ScaledTexels::products
    /// iterations  of the power iteration for the second axis
    Bc7Plane(const Bc7ScaledTexels<D>& texels, const Bc7RegionFit<D, 1, 4>& whole, const F (&product)[10], int iterations) {
        // The second axis is the principal axis of the covariance after the part of the first axis is subtracted (deflation).
        F rest[10], axis[4];
        const F first = whole.largestEigenvalue(0);
        for (std::size_t i = 0, at = 0; i < 4; ++i)
            for (std::size_t j = i; j < 4; ++j, ++at) rest[at] = hn::NegMulAdd(first * whole.axis(0)[i], whole.axis(0)[j], product[at]);
        const F second = Bc7LeastSquares<D>::template axisOf<4>(rest, iterations, axis);
        for (int t = 0; t < kTexelCount; ++t) {
            p[t] = whole.position(t);
            q[t] = texels.x[0][t] * axis[0];
            for (std::size_t c = 1; c < 4; ++c) q[t] = hn::MulAdd(texels.x[c][t], axis[c], q[t]);
        }
        outside = hn::Max(whole.trace(0) - first - second, zero());
    }
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
