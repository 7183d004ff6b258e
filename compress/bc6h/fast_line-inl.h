// BC6H, fast kernel: the line through the texels of a block, in v, by weighted least squares.
#if defined(LIGHTCOOK_COMPRESS_BC6H_FAST_LINE_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC6H_FAST_LINE_INL_H_
#undef LIGHTCOOK_COMPRESS_BC6H_FAST_LINE_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC6H_FAST_LINE_INL_H_
#endif

#include <hwy/highway.h>

#include "compress/bc6h/fast_block-inl.h"
#include "compress/bc6h/fast_texels-inl.h"
#include "compress/bc6h/values-inl.h"
#include "compress/block/lanes-inl.h"
#include "compress/block/principal_axis-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D, bool kSigned>
class Bc6hFastLine : Lanes<D>, public Bc6hFastLineEnds<D> {
    using typename Lanes<D>::F;
    using Lanes<D>::set, Lanes<D>::zero, Lanes<D>::clamp;
    using Values = Bc6hValues<D, kSigned>;
    using Texels = Bc6hFastTexels<D, kSigned>;

public:
    using Bc6hFastLineEnds<D>::a, Bc6hFastLineEnds<D>::d;
    F position[kTexelCount];  ///< of each texel on the line, in [0, 1]
    F index[kTexelCount];     ///< of each texel, 0 .. 15
    F oneColour;              ///< weighted squared error of the block in its mean colour

    /// Sets the line by two fits: to the projections of the texels onto the principal axis, then to the nearest indices on that line.
    void fit(const Texels& texels) {
        center(texels);
        start(texels);
        chooseIndices(texels);
        for (int t = 0; t < kTexelCount; ++t) position[t] = index[t] * set(1.0f / 15);
        leastSquares(texels);
    }

    /// Sets the nearest of the sixteen indices of each texel, in the weighted sense.
    void chooseIndices(const Texels& texels) {
        for (int t = 0; t < kTexelCount; ++t) {
            F along = zero(), length = set(1e-20f);
            for (int c = 0; c < 3; ++c) {
                const F wd = texels.weight[c][t] * d[c];
                along = hn::MulAdd(wd, texels.v[c][t] - a[c], along);
                length = hn::MulAdd(wd, d[c], length);
            }
            index[t] = hn::Round(clamp(along * roughInverse<D>(length) * set(15.0f), zero(), set(15.0f)));
        }
    }

private:
    /// Fits the line to projections onto the principal axis of v. Channels are scaled by the root of their share of the weight.
    void start(const Texels& texels) {
        F mean[3], axis[3];
        findAxis(texels, mean, axis);
        F low = set(1e30f), high = set(-1e30f);
        for (int t = 0; t < kTexelCount; ++t) {
            const F x = texels.v[0][t] - mean[0], y = texels.v[1][t] - mean[1], z = texels.v[2][t] - mean[2];
            position[t] = hn::MulAdd(x, axis[0], hn::MulAdd(y, axis[1], z * axis[2]));
            low = hn::Min(low, position[t]);
            high = hn::Max(high, position[t]);
        }
        const F perRange = set(1.0f) / hn::Max(high - low, set(1e-20f));
        for (F& p : position) p = (p - low) * perRange;
        leastSquares(texels);
    }

    /// Finds the mean and the principal axis of the block, with each channel scaled by the root of its share of the weight.
    HWY_INLINE void findAxis(const Texels& texels, F (&mean)[3], F (&axis)[3]) const {
        for (F& m : mean) m = zero();
        F texel[kTexelCount];
        for (int t = 0; t < kTexelCount; ++t) {
            texel[t] = texels.weight[0][t] + texels.weight[1][t] + texels.weight[2][t];
            for (int c = 0; c < 3; ++c) {
                mean[c] = hn::MulAdd(texel[t], texels.v[c][t], mean[c]);
            }
        }
        const F perTotal = set(1.0f) / (total_[0] + total_[1] + total_[2]);
        F scale[3];
        for (int c = 0; c < 3; ++c) {
            mean[c] = mean[c] * perTotal;
            scale[c] = hn::Sqrt(total_[c] * perTotal);
        }
        F m[6] = {zero(), zero(), zero(), zero(), zero(), zero()};  // covariance: xx xy xz yy yz zz
        for (int t = 0; t < kTexelCount; ++t) {
            const F x = texels.v[0][t] - mean[0], y = texels.v[1][t] - mean[1], z = texels.v[2][t] - mean[2];
            addProducts<D>(texel[t], x, y, z, m);
        }
        constexpr int kRow[6] = {0, 0, 0, 1, 1, 2}, kColumn[6] = {0, 1, 2, 1, 2, 2};
        for (int i = 0; i < 6; ++i) m[i] = m[i] * (scale[kRow[i]] * scale[kColumn[i]]);
        principalAxis<D>(m, 3, axis);
        for (int c = 0; c < 3; ++c) axis[c] = axis[c] * scale[c];
    }

    /// Sets the means of the channels, each with its own weights, and the weighted deviations from them.
    void center(const Texels& texels) {
        oneColour = zero();
        for (int c = 0; c < 3; ++c) {
            F total = set(1e-30f), mean = zero();
            for (int t = 0; t < kTexelCount; ++t) {
                total = total + texels.weight[c][t];
                mean = hn::MulAdd(texels.weight[c][t], texels.v[c][t], mean);
            }
            total_[c] = total;
            perTotal_[c] = set(1.0f) / total;
            mean_[c] = mean * perTotal_[c];
            for (int t = 0; t < kTexelCount; ++t) {
                const F away = texels.v[c][t] - mean_[c];
                weighted_[c][t] = texels.weight[c][t] * away;
                oneColour = hn::MulAdd(weighted_[c][t], away, oneColour);
            }
        }
    }

    /// Sets the weighted least-squares line for texels at these positions, channel by channel because each has its own weights. Works on
    /// deviations from the mean: no cancellation, and a constant block comes out exact.
    void leastSquares(const Texels& texels) {
        for (int c = 0; c < 3; ++c) {
            F meanK = zero();
            for (int t = 0; t < kTexelCount; ++t) meanK = hn::MulAdd(texels.weight[c][t], position[t], meanK);
            meanK = meanK * perTotal_[c];
            F kk = zero(), kv = zero();
            for (int t = 0; t < kTexelCount; ++t) {
                const F k = position[t] - meanK;
                kk = hn::MulAdd(texels.weight[c][t] * k, k, kk);
                kv = hn::MulAdd(weighted_[c][t], k, kv);
            }
            const F slope = hn::IfThenElseZero(kk > total_[c] * set(1e-12f), kv / hn::Max(kk, set(1e-35f)));
            // Clamp the ends near the range of the block: ends far outside would only fit rounding errors.
            const F slack = (texels.high[c] - texels.low[c]) * set(0.25f);
            const F least = hn::Max(texels.low[c] - slack, set(Values::kSmallest)),
                    most = hn::Min(texels.high[c] + slack, set(Values::kLargest));
            a[c] = clamp(hn::NegMulAdd(slope, meanK, mean_[c]), least, most);
            d[c] = clamp(hn::MulAdd(slope, set(1.0f) - meanK, mean_[c]), least, most) - a[c];
        }
    }

    F total_[3], perTotal_[3], mean_[3];  ///< of a channel: sum of the weights, its inverse, weighted mean of v
    F weighted_[3][kTexelCount];          ///< v less the mean, times the weight
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
