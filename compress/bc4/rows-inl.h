// Encodes rows of texels as BC4 or BC5 without gathering blocks: neighbouring blocks are loaded into lanes, fitted (fit-inl.h) and packed.
#if defined(LIGHTCOOK_COMPRESS_BC4_ROWS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC4_ROWS_INL_H_
#undef LIGHTCOOK_COMPRESS_BC4_ROWS_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC4_ROWS_INL_H_
#endif

#include <hwy/highway.h>

#include <array>
#include <cstddef>
#include <cstdint>

#include "compress/bc4/fit-inl.h"
#include "compress/block/texel_rows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D, int kChannels>
class Bc4Rows {
    using F = hn::Vec<D>;
    using DU = hn::RebindToUnsigned<D>;

public:
    Bc4Rows(const Bc4Search& search, const Bc4Codes& codes)
        : fit_(search, codes), least_((0 - codes.offset) / codes.scale), most_((codes.largest - codes.offset) / codes.scale) {}

    /// Encodes Lanes(d) blocks.
    /// texels   four rows of 4 Lanes(d) texels of four floats
    /// weights  four rows of significance, or null for 1 everywhere
    /// out      two words for each block and channel
    /// Returns true if a value was clamped into the range of the format.
    bool run(const std::array<const float*, 4>& texels, const std::array<const float*, 4>* weights, std::uint32_t* out) {
        std::array<F*, kChannels> planes;
        for (std::size_t c = 0; c < kChannels; ++c) planes[c] = value_[c];
        const bool clamped = loadTexels<D, kChannels>(texels, hn::Set(D(), least_), hn::Set(D(), most_), planes);
        F weight[kTexelCount];
        hn::Mask<D> nothing;
        if (weights)
            loadWeights<D>(*weights, weight, nothing);
        else
            for (F& w : weight) w = hn::Set(D(), 1.0f);
        hn::Vec<DU> word[2 * kChannels];
        for (int c = 0; c < kChannels; ++c) fit_.run(value_[c], weight, !weights, word[2 * c], word[2 * c + 1]);
        if constexpr (kChannels == 1)
            hn::StoreInterleaved2(word[0], word[1], DU(), out);
        else
            hn::StoreInterleaved4(word[0], word[1], word[2], word[3], DU(), out);
        return clamped;
    }

private:
    Bc4Fit<D> fit_;
    float least_, most_;  ///< range of the format
    F value_[kChannels][kTexelCount];
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
