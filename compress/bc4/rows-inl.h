// Encodes rows of texels as BC4 or BC5 without gathering blocks: neighbouring blocks are loaded into lanes, fitted (fast-inl.h at effort 0,
// else fit-inl.h) and packed.
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
#include <cstring>

#include "compress/bc4/fast-inl.h"
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
        : fast_(codes),
          fit_(search, codes),
          least_((0 - codes.offset) / codes.scale),
          most_((codes.largest - codes.offset) / codes.scale),
          isFast_(search.usesFastKernel()) {}

    /// Encodes blocks.
    /// texels   four rows of 4 Lanes(d) texels of four floats
    /// weights  four rows of significance, or null for 1 everywhere
    /// count    the number of blocks to write
    /// out      receives them at the latest in finish()
    /// Returns true if a value was clamped into the range of the format.
    HWY_INLINE bool run(const std::array<const float*, 4>& texels, const std::array<const float*, 4>* weights, std::size_t count,
                        std::byte* out) {
        std::array<F*, kChannels> planes;
        F value[kChannels][kTexelCount], lowest[kChannels], highest[kChannels];
        for (std::size_t c = 0; c < kChannels; ++c) planes[c] = value[c];
        loadChannels<D>(texels, planes);
        bool clamped = false;
        for (int c = 0; c < kChannels; ++c)
            clamped |= clampTexels<D>(hn::Set(D(), least_), hn::Set(D(), most_), value[c], lowest[c], highest[c]);
        const bool weightsAreOne = !weights || areWeightsOne<D>(*weights);
        if (isFast_ && weightsAreOne) {
            for (int c = 0; c < kChannels; ++c) fast_.fit(value[c], lowest[c], highest[c], fitted_[next_][c]);
            finish();
            waiting_ = out, waitingCount_ = count, next_ = 1 - next_;
        } else {
            fitWeighted(value, lowest, highest, weightsAreOne ? nullptr : weights, count, out);
        }
        return clamped;
    }

    /// Writes the blocks that wait for their indices.
    HWY_INLINE void finish() {
        if (!waiting_) return;
        hn::Vec<DU> word[2 * kChannels];
        for (int c = 0; c < kChannels; ++c) fast_.pack(fitted_[1 - next_][c], word[2 * c], word[2 * c + 1]);
        store(word, waitingCount_, waiting_);
        waiting_ = nullptr;
    }

private:
    /// Encodes blocks of any weights. Those whose weights are all 1 get the bytes that they get beside other blocks.
    HWY_NOINLINE void fitWeighted(const F (*value)[kTexelCount], const F* lowest, const F* highest,
                                  const std::array<const float*, 4>* weights, std::size_t count, std::byte* out) {
        F weight[kTexelCount];
        hn::Mask<D> nothing;
        if (weights)
            loadWeights<D>(*weights, weight, nothing);
        else
            for (F& w : weight) w = hn::Set(D(), 1.0f);
        hn::Vec<DU> word[2 * kChannels];
        for (int c = 0; c < kChannels; ++c) {
            auto &low = word[2 * c], &high = word[2 * c + 1];
            fit_.run(value[c], weight, !weights, low, high);
            if (isFast_) fast_.replaceUnweighted(value[c], lowest[c], highest[c], weight, low, high);
        }
        store(word, count, out);
    }

    HWY_INLINE void store(const hn::Vec<DU>* word, std::size_t count, std::byte* out) const {
        constexpr std::size_t kBytes = 8 * kChannels, kLanes = hn::MaxLanes(D());
        HWY_ALIGN std::uint32_t words[2 * kChannels * kLanes];
        if constexpr (kChannels == 1)
            hn::StoreInterleaved2(word[0], word[1], DU(), words);
        else
            hn::StoreInterleaved4(word[0], word[1], word[2], word[3], DU(), words);
        if (count == kLanes)
            std::memcpy(out, words, kBytes * kLanes);
        else
            std::memcpy(out, words, kBytes * count);
    }

    Bc4Fast<D> fast_;
    Bc4Fit<D> fit_;
    typename Bc4Fast<D>::Fitted fitted_[2][kChannels];
    std::byte* waiting_ = nullptr;
    std::size_t waitingCount_ = 0;
    int next_ = 0;
    float least_, most_;  ///< range of the format
    const bool isFast_;
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
