// Encodes rows of texels as BC1 or BC3 without gathering blocks: neighbouring blocks are loaded into lanes, fitted (fit-inl.h) and packed.
#if defined(LIGHTCOOK_COMPRESS_BC1_ROWS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC1_ROWS_INL_H_
#undef LIGHTCOOK_COMPRESS_BC1_ROWS_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC1_ROWS_INL_H_
#endif

#include <hwy/highway.h>

#include <array>
#include <cstddef>
#include <cstdint>

#include "compress/bc1/fit-inl.h"
#include "compress/bc4/fast-inl.h"
#include "compress/bc4/fit-inl.h"
#include "compress/bc4/search.h"
#include "compress/block/texel_rows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D, bool kHasAlpha>
class Bc1Rows {
    using F = hn::Vec<D>;
    using DU = hn::RebindToUnsigned<D>;

public:
    explicit Bc1Rows(const EncodeOptions& options)
        : colour_(bc1SearchOf(options.effort), options, !kHasAlpha),
          alpha_(bc3AlphaSearchOf(options.effort)),
          fastAlpha_(kBc4Unorm),
          alphaIsFast_(bc3AlphaSearchOf(options.effort).usesFastKernel()) {}

    /// Encodes Lanes(d) blocks.
    /// texels   four rows of 4 Lanes(d) texels of four floats
    /// weights  four rows of significance, or null for 1 everywhere
    /// out      two words for each block of BC1, four for BC3
    /// Returns true if a value was clamped into [0, 1].
    bool run(const std::array<const float*, 4>& texels, const std::array<const float*, 4>* weights, std::uint32_t* out) {
        Bc1Texels<D>& into = colour_.texels();
        const F least = hn::Zero(D()), most = hn::Set(D(), 1.0f);
        F alpha[kTexelCount];
        bool clamped;
        if constexpr (kHasAlpha)
            clamped = loadTexels<D, 4>(texels, least, most, std::array<F*, 4>{into.value[0], into.value[1], into.value[2], alpha});
        else
            clamped = loadTexels<D, 3>(texels, least, most, std::array<F*, 3>{into.value[0], into.value[1], into.value[2]});
        const bool weightsAreOne = !weights || areWeightsOne<D>(*weights);
        hn::Mask<D> nothing;
        if (weightsAreOne)
            for (F& w : into.weight) w = most;
        else
            loadWeights<D>(*weights, into.weight, nothing);
        hn::Vec<DU> ends, indices;
        into.measure(weightsAreOne);
        colour_.run(ends, indices);
        if constexpr (kHasAlpha) {
            hn::Vec<DU> low, high;
            F lowest = least, highest = most;
            if (alphaIsFast_) clampTexels<D>(least, most, alpha, lowest, highest);  // for the range
            if (alphaIsFast_ && weightsAreOne) {
                typename Bc4Fast<D>::Fitted fitted;
                fastAlpha_.fit(alpha, lowest, highest, fitted);
                fastAlpha_.pack(fitted, low, high);
            } else {
                alpha_.run(alpha, into.weight, weightsAreOne, low, high);
                if (alphaIsFast_) fastAlpha_.replaceUnweighted(alpha, lowest, highest, into.weight, low, high);
            }
            hn::StoreInterleaved4(low, high, ends, indices, DU(), out);
        } else {
            hn::StoreInterleaved2(ends, indices, DU(), out);
        }
        return clamped;
    }

private:
    Bc1Fit<D> colour_;
    Bc4Fit<D> alpha_;
    Bc4Fast<D> fastAlpha_;
    const bool alphaIsFast_;
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
