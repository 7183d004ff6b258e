// BC6H: first positions of the texels on the line of their region, by projection onto its principal axis.
//
// The axis is taken in v, with each channel scaled by the root of its share of the total weight. Then a channel in which errors weigh more
// turns the axis more, as in a fit with one weight per texel and channel.
#if defined(LIGHTCOOK_COMPRESS_BC6H_START_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC6H_START_INL_H_
#undef LIGHTCOOK_COMPRESS_BC6H_START_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC6H_START_INL_H_
#endif

#include <hwy/highway.h>

#include "compress/bc6h/regions-inl.h"
#include "compress/bc6h/texels-inl.h"
#include "compress/block/lanes-inl.h"
#include "compress/block/principal_axis-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D>
class Bc6hStart : Lanes<D> {
    using typename Lanes<D>::F, typename Lanes<D>::M;
    using Lanes<D>::set, Lanes<D>::zero, Lanes<D>::clamp, Lanes<D>::select;

public:
    /// Scales the texels around their mean.
    template <bool kSigned>
    void load(const Bc6hTexels<D, kSigned>& texels) {
        F total = set(1e-30f), share[3], mean[3];
        for (int c = 0; c < 3; ++c) share[c] = mean[c] = zero();
        for (int t = 0; t < kTexelCount; ++t) {
            significance_[t] = texels.significance[t];
            weight_[t] = texels.startWeight[0][t] + texels.startWeight[1][t] + texels.startWeight[2][t];
            total = total + weight_[t];
            for (int c = 0; c < 3; ++c) {
                share[c] = share[c] + texels.startWeight[c][t];
                mean[c] = hn::MulAdd(weight_[t], texels.target[c][t], mean[c]);
            }
        }
        for (int c = 0; c < 3; ++c) {
            const F scale = hn::Sqrt(share[c] / total), middle = mean[c] / total;
            for (int t = 0; t < kTexelCount; ++t) scaled_[c][t] = (texels.target[c][t] - middle) * scale;
        }
    }

    /// Sets the position of each texel on the principal axis of its region: 0 and 1 are the outermost significant texels.
    template <class Regions>
    void positions(const Regions& regions, F (&position)[kTexelCount]) const {
        for (int r = 0; r < Regions::kCount; ++r) {
            F mean[3], axis[3];
            findAxis(regions, r, mean, axis);
            F low = set(1e30f), high = set(-1e30f), along[kTexelCount];
            for (int t = 0; t < kTexelCount; ++t) {
                along[t] = hn::MulAdd(scaled_[0][t], axis[0], hn::MulAdd(scaled_[1][t], axis[1], scaled_[2][t] * axis[2]));
                const M counts = regions.inRegion(r, t, significance_[t]) > zero();
                low = select(counts, hn::Min(low, along[t]), low);
                high = select(counts, hn::Max(high, along[t]), high);
            }
            const F perRange = set(1.0f) / hn::Max(high - low, set(1e-20f));
            for (int t = 0; t < kTexelCount; ++t) {
                const F placed = clamp((along[t] - low) * perRange, zero(), set(1.0f));
                position[t] = r == 0 ? placed : regions.pick(t, position[t], placed);
            }
        }
    }

private:
    /// Finds the mean and the principal axis of a region, in scaled channels.
    template <class Regions>
    HWY_INLINE void findAxis(const Regions& regions, int r, F (&mean)[3], F (&axis)[3]) const {
        F total = set(1e-30f);
        for (F& m : mean) m = zero();
        for (int t = 0; t < kTexelCount; ++t) {
            const F w = regions.inRegion(r, t, weight_[t]);
            total = total + w;
            for (int c = 0; c < 3; ++c) mean[c] = hn::MulAdd(w, scaled_[c][t], mean[c]);
        }
        const F perTotal = set(1.0f) / total;
        for (int c = 0; c < 3; ++c) mean[c] = mean[c] * perTotal;
        F m[6] = {zero(), zero(), zero(), zero(), zero(), zero()};  // covariance: xx xy xz yy yz zz
        for (int t = 0; t < kTexelCount; ++t) {
            const F w = regions.inRegion(r, t, weight_[t]);
            const F x = scaled_[0][t] - mean[0], y = scaled_[1][t] - mean[1], z = scaled_[2][t] - mean[2];
            addProducts<D>(w, x, y, z, m);
        }
        principalAxis<D>(m, 4, axis);
    }

    F scaled_[3][kTexelCount];  ///< v around the mean, channels scaled
    F weight_[kTexelCount], significance_[kTexelCount];
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
