// BC7, closed forms: texels of a block in each lane, scaled so that the error is a plain squared distance, and their moments.
#if defined(LIGHTCOOK_COMPRESS_BC7_CLOSED_FORM_TEXELS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC7_CLOSED_FORM_TEXELS_INL_H_
#undef LIGHTCOOK_COMPRESS_BC7_CLOSED_FORM_TEXELS_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC7_CLOSED_FORM_TEXELS_INL_H_
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

#include "compress/block/block.h"
#include "compress/block/lanes-inl.h"
#include "compress/block/texel_rows-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D>
class Bc7ScaledTexels : Lanes<D> {
    using typename Lanes<D>::F, typename Lanes<D>::M;
    using Lanes<D>::set, Lanes<D>::zero, Lanes<D>::select;

public:
    F x[4][kTexelCount];                   ///< 255 times the value times scale[c], less mean[c]
    F weight[kTexelCount];                 ///< significance, or 1 throughout an insignificant block
    F mean[4], total;                      ///< weighted mean of each channel; sum of the weights
    F opaqueError;                         ///< error of replacing alpha by 1
    M opaque, hasAlpha;                    ///< lanes that may use modes without alpha, and mode 7; some may use both
    M constant;                            ///< lanes whose significant texels are all equal
    M nothing;                             ///< insignificant blocks
    bool uniform;                          ///< all weights of all lanes are 1
    std::array<float, 4> scale, perScale;  ///< root of the channel's weight, the largest being 1; its inverse

    explicit Bc7ScaledTexels(const EncodeOptions& options) {
        // A channel without weight keeps a small one, so that its ends are still those that fit its texels.
        constexpr float kLeast = 1.0f / 1024;
        const float largest = *std::max_element(options.channelWeights.begin(), options.channelWeights.end());
        for (std::size_t c = 0; c < 4; ++c) {
            scale[c] = largest > 0 ? std::max(std::sqrt(options.channelWeights[c] / largest), kLeast) : 1.0f;
            perScale[c] = 1 / scale[c];
        }
    }

    /// Loads Lanes(d) blocks and sets all members. Returns true if a value was clamped into [0, 1].
    /// texels   four rows of 4 Lanes(d) texels of four floats
    /// weights  four rows of significance, or null for 1 everywhere
    bool load(const std::array<const float*, 4>& texels, const std::array<const float*, 4>* weights) {
        const bool clamped = loadValues(texels);
        uniform = true;
        nothing = set(1.0f) < zero();
        for (F& w : weight) w = set(1.0f);
        if (weights) loadSignificance(*weights);
        findOpaque();
        center();
        return clamped;
    }
    /// Loads Lanes(d) gathered blocks, whose values are in [0, 1] and of which none is insignificant.
    void load(const Block* const* blocks) {
        const D d;
        HWY_ALIGN float buffer[hn::MaxLanes(D())];
        const auto gathered = [&](const auto& valueOf) {
            for (std::size_t lane = 0; lane < hn::Lanes(d); ++lane) buffer[lane] = valueOf(*blocks[lane]);
            return hn::Load(d, buffer);
        };
        nothing = set(1.0f) < zero();
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            weight[t] = gathered([t](const Block& block) { return block.significance[t]; });
            for (std::size_t c = 0; c < 4; ++c)
                x[c][t] = gathered([c, t](const Block& block) { return block.channel[c][t]; }) * set(255 * scale[c]);
        }
        replaceUnweighted();
        findOpaque();
        center();
    }
    /// Computes the sums of weight times the product of two channels: rr rg rb ra gg gb ga bb ba aa.
    void products(F (&product)[10]) const {
        F rr = zero(), rg = rr, rb = rr, ra = rr, gg = rr, gb = rr, ga = rr, bb = rr, ba = rr, aa = rr;
        for (int t = 0; t < kTexelCount; ++t) {
            const F r = x[0][t], g = x[1][t], b = x[2][t], a = x[3][t], w = weight[t];
            const F wr = w * r, wg = w * g, wb = w * b, wa = w * a;
            rr = hn::MulAdd(wr, r, rr), rg = hn::MulAdd(wr, g, rg), rb = hn::MulAdd(wr, b, rb), ra = hn::MulAdd(wr, a, ra);
            gg = hn::MulAdd(wg, g, gg), gb = hn::MulAdd(wg, b, gb), ga = hn::MulAdd(wg, a, ga);
            bb = hn::MulAdd(wb, b, bb), ba = hn::MulAdd(wb, a, ba), aa = hn::MulAdd(wa, a, aa);
        }
        const F all[10] = {rr, rg, rb, ra, gg, gb, ga, bb, ba, aa};
        for (int i = 0; i < 10; ++i) product[i] = all[i];
    }
    /// Returns the value of a texel, in 0 .. 255.
    F valueOf(std::size_t channel, std::size_t texel) const { return (x[channel][texel] + mean[channel]) * set(perScale[channel]); }

private:
    bool loadValues(const std::array<const float*, 4>& texels) {
        const bool clamped = loadTexels<D, 4>(texels, zero(), set(1.0f), std::array<F*, 4>{x[0], x[1], x[2], x[3]});
        for (std::size_t c = 0; c < 4; ++c)
            for (F& value : x[c]) value = value * set(255 * scale[c]);
        return clamped;
    }
    /// Replaces texels of significance 0 by a significant one of their block. All texels of an insignificant block count.
    void loadSignificance(const std::array<const float*, 4>& rows) {
        loadWeights<D>(rows, weight, nothing);
        replaceUnweighted();
    }
    /// Replaces texels without weight, and sets `uniform`.
    void replaceUnweighted() {
        M ones = zero() == zero(), all = ones;
        for (const F& w : weight) {
            ones = hn::And(ones, w == set(1.0f));
            all = hn::And(all, w > zero());
        }
        uniform = hn::AllTrue(D(), ones);
        if (hn::AllTrue(D(), all)) return;
        for (F(&channel)[kTexelCount] : x) {
            F stand = zero();
            for (int t = 0; t < kTexelCount; ++t) stand = select(weight[t] > zero(), channel[t], stand);
            for (int t = 0; t < kTexelCount; ++t) channel[t] = select(weight[t] > zero(), channel[t], stand);
        }
    }

    void findOpaque() {
        const F largest = set(255 * scale[3]);
        opaqueError = total = zero();
        for (int t = 0; t < kTexelCount; ++t) {
            const F missing = largest - x[3][t];
            opaqueError = hn::MulAdd(weight[t] * missing, missing, opaqueError);
            total = total + weight[t];
        }
        // Modes without alpha are worth a try in nearly opaque blocks too.
        opaque = opaqueError <= total * set(4 * scale[3] * scale[3]);
        hasAlpha = opaqueError > zero();
    }
    void center() {
        const F perTotal = set(1.0f) / total;
        constant = zero() == zero();
        for (std::size_t c = 0; c < 4; ++c) {
            const F first = x[c][0];
            F sum = zero(), spread = zero();
            for (int t = 1; t < kTexelCount; ++t) {
                x[c][t] = x[c][t] - first;
                sum = hn::MulAdd(weight[t], x[c][t], sum);
                spread = hn::Or(spread, x[c][t]);
            }
            // Exact for channels of one value, as opaque alpha is.
            const F middle = sum * perTotal;
            mean[c] = first + middle;
            x[c][0] = zero() - middle;
            for (int t = 1; t < kTexelCount; ++t) x[c][t] = x[c][t] - middle;
            constant = hn::And(constant, spread == zero());
        }
    }
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
