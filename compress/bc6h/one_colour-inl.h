// BC6H: one colour for a whole block, the fallback where every line is worse. The best colour is the weighted mean in the metric; the
// 16-bit mode holds it as finely as a half does.
#if defined(LIGHTCOOK_COMPRESS_BC6H_ONE_COLOUR_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC6H_ONE_COLOUR_INL_H_
#undef LIGHTCOOK_COMPRESS_BC6H_ONE_COLOUR_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC6H_ONE_COLOUR_INL_H_
#endif

#include <hwy/highway.h>

#include "compress/bc6h/texels-inl.h"
#include "compress/bc6h/values-inl.h"
#include "compress/block/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D, bool kSigned>
class Bc6hOneColour : Lanes<D> {
    using typename Lanes<D>::F, typename Lanes<D>::M;
    using Lanes<D>::set, Lanes<D>::zero, Lanes<D>::select;
    using Values = Bc6hValues<D, kSigned>;
    using Texels = Bc6hTexels<D, kSigned>;

public:
    /// Returns the error of the weighted mean for all texels, in the metric. mean receives it.
    static F errorOf(const Texels& texels, F (&mean)[3]) {
        F error = zero();
        for (int c = 0; c < 3; ++c) {
            F total = set(1e-30f), sum = zero();
            for (int t = 0; t < kTexelCount; ++t) {
                total = total + texels.errorWeight[c][t];
                sum = sum + texels.errorWeight[c][t] * texels.value[c][t];
            }
            mean[c] = sum / total;
            for (int t = 0; t < kTexelCount; ++t) {
                const F miss = texels.value[c][t] - mean[c];
                error = error + texels.errorWeight[c][t] * miss * miss;
            }
        }
        return error;
    }

    /// Returns the integer v whose light is nearest to a value of the metric, by bisection.
    static F wholeVOf(const Values& values, F value) {
        F low = set(Values::kSmallest), high = set(Values::kLargest);
        for (int i = 0; i < 17; ++i) {
            const F middle = hn::Floor((low + high) * set(0.5f));
            const M above = values.metric(Values::lightOf(middle)) > value;
            low = select(above, low, middle);
            high = select(above, middle, high);
        }
        const F under = value - values.metric(Values::lightOf(low)), over = values.metric(Values::lightOf(high)) - value;
        return select(hn::Abs(under) <= hn::Abs(over), low, high);
    }
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
