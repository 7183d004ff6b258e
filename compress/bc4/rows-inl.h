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
    static constexpr std::size_t kLanes = hn::MaxLanes(D());

public:
    Bc4Rows(const Bc4Search& search, const Bc4Codes& codes)
        : fit_(search, codes), least_((0 - codes.offset) / codes.scale), most_((codes.largest - codes.offset) / codes.scale) {}

    /// Encodes Lanes(d) blocks.
    /// texels   four rows of 4 Lanes(d) texels of four floats
    /// weights  four rows of significance, or null for 1 everywhere
    /// out      two words for each block and channel
    /// Returns true if a value was clamped into the range of the format.
    bool run(const std::array<const float*, 4>& texels, const std::array<const float*, 4>* weights, std::uint32_t* out) {
        const bool clamped = load(texels);
        F weight[kTexelCount];
        hn::Mask<D> nothing;
        if (weights)
            loadWeights<D>(*weights, weight, nothing);
        else
            for (F& w : weight) w = hn::Set(D(), 1.0f);
        hn::Vec<DU> word[2 * kChannels];
        for (int c = 0; c < kChannels; ++c) fit_.run(value_[c], weight, word[2 * c], word[2 * c + 1]);
        if constexpr (kChannels == 1)
            hn::StoreInterleaved2(word[0], word[1], DU(), out);
        else
            hn::StoreInterleaved4(word[0], word[1], word[2], word[3], DU(), out);
        return clamped;
    }

private:
    bool load(const std::array<const float*, 4>& texels) {
        const D d;
        HWY_ALIGN float plane[kChannels][4 * kLanes];
        const F least = hn::Set(d, least_), most = hn::Set(d, most_);
        hn::Mask<D> outside = least > most;
        for (std::size_t y = 0; y < 4; ++y) {
            for (std::size_t part = 0; part < 4; ++part) {
                F x[4];
                hn::LoadInterleaved4(d, texels[y] + part * 4 * hn::Lanes(d), x[0], x[1], x[2], x[3]);
                for (int c = 0; c < kChannels; ++c) {
                    outside = hn::Or(outside, hn::Or(x[c]<least, x[c]> most));
                    hn::Store(hn::Min(hn::Max(x[c], least), most), d, plane[c] + part * hn::Lanes(d));
                }
            }
            for (int c = 0; c < kChannels; ++c) {
                F* v = value_[c] + 4 * y;
                hn::LoadInterleaved4(d, plane[c], v[0], v[1], v[2], v[3]);
            }
        }
        return !hn::AllFalse(d, outside);
    }

    Bc4Fit<D> fit_;
    float least_, most_;  ///< range of the format
    F value_[kChannels][kTexelCount];
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
