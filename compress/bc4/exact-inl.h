// BC4: exhaustive search for the pair of endpoints with the least error, for one channel of one block. Branch and bound: lanes hold boxes
// of endpoint pairs.
//
// Bound: in a box, both endpoints come from intervals of s codes. Any palette entry between them differs by at most (s - 1) / 2 from the
// entry of the pair in the middle of the box. So the error of the middle pair, with the distance of each texel reduced by (s - 1) / 2, is a
// lower bound of the error of every pair in the box.
// Order: boxes of 16 x 16 codes first; those whose bound does not exceed the best known error are cut into boxes of 4 x 4, and these into
// single pairs.
//
// The result is the smallest (error, mode, low, high) at any vector width: lanes are independent, and only boxes that are certainly worse
// are pruned.
#if defined(LIGHTCOOK_COMPRESS_BC4_EXACT_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC4_EXACT_INL_H_
#undef LIGHTCOOK_COMPRESS_BC4_EXACT_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC4_EXACT_INL_H_
#endif

#include <hwy/highway.h>

#include <array>
#include <cstddef>

#include "compress/bc4/search.h"
#include "compress/block/block.h"
#include "compress/block/lanes-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D>
class Bc4Exact : Lanes<D> {
    using typename Lanes<D>::F;
    using Lanes<D>::set;

public:
    explicit Bc4Exact(const Bc4Codes& codes) : codes_(codes) {}

    /// Replaces the endpoints in found, a result for this channel of the block, by the best ones. Does not update its indices.
    void run(const Block& block, std::size_t channel, Bc4Result& found) {
        load(block, channel);
        best_ = found;
        const F low = set(static_cast<float>(found.low)), high = set(static_cast<float>(found.high));
        best_.error = hn::GetLane(found.sixValues ? errorOf<true>(low, high, 0) : errorOf<false>(low, high, 0));
        if (best_.error > kRounding * kRounding * totalWeight_) {
            search<false>();
            search<true>();
        }
        found.low = best_.low, found.high = best_.high, found.sixValues = best_.sixValues, found.error = best_.error;
    }

private:
    static constexpr int kSide = 16, kSmallSide = 4;  ///< sides of the boxes [codes]
    static constexpr int kBoxes = 256 / kSide * (256 / kSide + 1) / 2;
    static constexpr float kRounding = 1e-4f;        ///< upper bound of the rounding error of a distance [codes]
    static constexpr float kSumRounding = 1.00001f;  ///< upper bound of the relative rounding error of a sum

    /// Collects the distinct values of the significant texels, each with the total weight of its texels.
    void load(const Block& block, std::size_t channel) {
        count_ = 0;
        totalWeight_ = 0;
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            const float weight = block.significance[t];
            if (!(weight > 0)) continue;
            totalWeight_ += weight;
            const float value = block.channel[channel][t] * codes_.scale + codes_.offset;
            std::size_t i = 0;
            while (i < count_ && value_[i] != value) ++i;
            if (i == count_) {
                value_[count_] = value;
                weight_[count_++] = 0;
            }
            weight_[i] += weight;
        }
    }

    /// Returns the error of these endpoints, with the distance of each texel reduced by `tolerance` codes.
    template <bool kSix>
    HWY_INLINE F errorOf(F low, F high, float tolerance) const {
        constexpr float kSteps = kSix ? 5.0f : 7.0f;
        const F range = high - low, scale = set(kSteps) / hn::Max(range, set(0.5f)), unit = range * set(1.0f / kSteps);
        const F zero = hn::Zero(D()), last = set(kSteps), off = set(tolerance), largest = set(codes_.largest);
        F error = zero;
        for (std::size_t i = 0; i < count_; ++i) {
            const F value = set(value_[i]), above = value - low;
            const F step = hn::Round(hn::Min(hn::Max(above * scale, zero), last));
            F miss = hn::Max(hn::Abs(hn::NegMulAdd(step, unit, above)) - off, zero);
            if constexpr (kSix) miss = hn::Min(miss, hn::Min(value, largest - value));
            error = hn::MulAdd(set(weight_[i]) * miss, miss, error);
        }
        return error;
    }

    template <bool kSix>
    void search() {
        struct Boxes {
            HWY_ALIGN float low[kBoxes + 64], high[kBoxes + 64];
            Boxes() {
                std::size_t n = 0;
                for (int a = 0; a < 256; a += kSide)
                    for (int b = a; b < 256; b += kSide) low[n] = static_cast<float>(a), high[n++] = static_cast<float>(b);
                // Loads of whole vectors read beyond the last box.
                for (; n < kBoxes + 64; ++n) low[n] = high[n] = 0;
            }
        };
        static const Boxes boxes;
        const D d;
        constexpr float kMiddle = (kSide - 1) / 2.0f;
        HWY_ALIGN float bound[kBoxes + hn::MaxLanes(D())];
        for (std::size_t i = 0; i < kBoxes; i += hn::Lanes(d))
            hn::Store(
                errorOf<kSix>(hn::Load(d, boxes.low + i) + set(kMiddle), hn::Load(d, boxes.high + i) + set(kMiddle), kMiddle + kRounding),
                d, bound + i);
        for (std::size_t i = 0; i < kBoxes; ++i)
            if (mayHold(bound[i])) searchBox<kSix>(boxes.low[i], boxes.high[i]);
    }

    bool mayHold(float bound) const { return bound <= best_.error * kSumRounding; }

    /// The pairs of a 4 x 4 grid, row by row, in steps of kStep codes.
    template <int kStep>
    struct Grid {
        static constexpr std::size_t kCount = 16;
        HWY_ALIGN float low[kCount + 64], high[kCount + 64];
        Grid() {
            for (std::size_t i = 0; i < kCount + 64; ++i) {
                const std::size_t row = i % kCount / 4, column = i % 4;
                low[i] = static_cast<float>(row * kStep);
                high[i] = static_cast<float>(column * kStep);
            }
        }
    };

    template <bool kSix>
    void searchBox(float low, float high) {
        static const Grid<kSmallSide> grid;
        const D d;
        constexpr float kMiddle = (kSmallSide - 1) / 2.0f;
        HWY_ALIGN float bound[Grid<kSmallSide>::kCount + hn::MaxLanes(D())];
        for (std::size_t i = 0; i < grid.kCount; i += hn::Lanes(d))
            hn::Store(errorOf<kSix>(hn::Load(d, grid.low + i) + set(low + kMiddle), hn::Load(d, grid.high + i) + set(high + kMiddle),
                                    kMiddle + kRounding),
                      d, bound + i);
        for (std::size_t i = 0; i < grid.kCount; ++i)
            if (grid.low[i] + low <= grid.high[i] + high && mayHold(bound[i])) tryPairs<kSix>(low + grid.low[i], high + grid.high[i]);
    }

    template <bool kSix>
    void tryPairs(float low, float high) {
        static const Grid<1> grid;
        const D d;
        HWY_ALIGN float error[hn::MaxLanes(D())];
        for (std::size_t first = 0; first < grid.kCount; first += hn::Lanes(d)) {
            const F errors = errorOf<kSix>(hn::Load(d, grid.low + first) + set(low), hn::Load(d, grid.high + first) + set(high), 0);
            if (hn::AllFalse(d, errors <= set(best_.error))) continue;
            hn::Store(errors, d, error);
            for (std::size_t lane = 0; lane < hn::Lanes(d) && first + lane < grid.kCount; ++lane)
                take<kSix>(static_cast<int>(low + grid.low[first + lane]), static_cast<int>(high + grid.high[first + lane]), error[lane]);
        }
    }

    /// Keeps a pair where it is valid and better. The eight-value mode needs low < high: equal bytes select the six-value mode.
    template <bool kSix>
    void take(int low, int high, float error) {
        if (low > high || (!kSix && low == high) || high > static_cast<int>(codes_.largest)) return;
        const auto rank = [](bool six, int a, int b) { return (six ? 65536 : 0) + 256 * a + b; };
        if (error > best_.error || (error == best_.error && rank(kSix, low, high) >= rank(best_.sixValues, best_.low, best_.high))) return;
        best_.low = low, best_.high = high, best_.sixValues = kSix, best_.error = error;
    }

    const Bc4Codes codes_;
    std::size_t count_ = 0;
    std::array<float, kTexelCount> value_, weight_;
    float totalWeight_ = 0;
    Bc4Result best_;
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
