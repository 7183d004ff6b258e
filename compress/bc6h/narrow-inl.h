// BC6H unsigned at low effort: blocks of a narrow range of light, in 16-bit integers. One block in each lane of floats, two texels in each
// lane of integers.
//
// In such a block the weight of an error in v is nearly a product: of the squared slope of the metric at the mean of a channel, and of one
// weight for each texel. Then the line of fast_line-inl.h has closed forms in sums that all channels share:
//
// 1. Texels become halves, and their distances from the lowest value of each channel are scaled to kRange.
// 2. Where the slope changes by more than kEven, a texel's weight is the squared slope at the mean of its channels, by a quadratic function
//    of this mean. Else all weights are the same, and a vector of such blocks leaves them out.
// 3. Sums and products give the covariance, and so the principal axis in the metric. The projections onto it are divided into fifteen
//    steps.
// 4. The least-squares line through these steps follows from the sums of k, k^2 and k d. Its ends are rounded to codes (fast_block-inl.h).
// 5. The indices are the nearest steps between the codes. The error follows from the same sums.
//
// Other blocks go to the kernel in floats, or to the full search. Integers and plain operations on floats only: a block gets the same bytes
// at any vector width, and with or without weights that are all the same.
#if defined(LIGHTCOOK_COMPRESS_BC6H_NARROW_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_BC6H_NARROW_INL_H_
#undef LIGHTCOOK_COMPRESS_BC6H_NARROW_INL_H_
#else
#define LIGHTCOOK_COMPRESS_BC6H_NARROW_INL_H_
#endif

#include <hwy/highway.h>

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "compress/bc6h/fast_block-inl.h"
#include "compress/bc6h/values-inl.h"
#include "compress/block/block.h"
#include "compress/block/lanes-inl.h"
#include "compress/block/pairs-inl.h"
#include "compress/block/principal_axis-inl.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

template <class D>
class Bc6hNarrow : Pairs<D> {
    using typename Pairs<D>::F, typename Pairs<D>::M, typename Pairs<D>::DI, typename Pairs<D>::I, typename Pairs<D>::DS,
        typename Pairs<D>::S;
    using Pairs<D>::set, Pairs<D>::zero, Pairs<D>::clamp, Pairs<D>::select, Pairs<D>::kPairs;
    using Pairs<D>::setBoth, Pairs<D>::inPairs, Pairs<D>::inBoth, Pairs<D>::lowBitsOf, Pairs<D>::mulPairs, Pairs<D>::dot, Pairs<D>::sumOf,
        Pairs<D>::smallSumOf, Pairs<D>::minInBoth, Pairs<D>::maxInBoth;
    using Values = Bc6hValues<D, false>;

public:
    /// Error of blocks that the kernel in floats shall encode.
    static constexpr float kLeft = -1;

    explicit Bc6hNarrow(const EncodeOptions& options)
        : scale_(options.hdrMetric == HdrMetric::Linear ? kLinearScale : options.hdrScale),
          widest_(options.hdrMetric == HdrMetric::Log ? kWide : kWideElsewhere) {
        const float slope = options.hdrMetric == HdrMetric::Linear ? kLinearScale / 65504 : 1;
        for (std::size_t c = 0; c < 3; ++c) rootWeight_[c] = std::sqrt(options.channelWeights[c]) * slope;
    }

    /// Begins to encode Lanes(d) blocks. finish() is a call of its own, so that the caller can begin other blocks between the two: the axis
    /// and the endpoints take long to compute, though few operations. Two vectors of blocks may be under way.
    /// texels, weights  see Bc6hFast::run
    /// Returns true if a value was clamped into the range of the format.
    HWY_INLINE bool begin(const std::array<const float*, 4>& texels, const std::array<const float*, 4>* weights) {
        Blocks& blocks = blocks_[newest_ ^= 1];
        const bool clamped = load(texels, blocks);
        if (weights)
            loadCounting(*weights, blocks);
        else
            countAll(blocks);
        measureRanges(blocks);
        blocks.areWeighted = !blocks.allCount || !hn::AllTrue(D(), hn::Or(blocks.even, hn::Not(blocks.narrow)));
        if (hn::AllFalse(D(), blocks.narrow)) return clamped;
        if (blocks.areWeighted)
            findAxis<true>(blocks);
        else
            findAxis<false>(blocks);
        return clamped;
    }
    /// Computes the endpoints of the blocks that were begun last.
    HWY_INLINE void fitLine() {
        Blocks& blocks = blocks_[newest_];
        if (hn::AllFalse(D(), blocks.narrow)) return;
        if (blocks.areWeighted)
            fitLine<true>(blocks);
        else
            fitLine<false>(blocks);
    }
    /// Says that no blocks follow: the next finish() is for the last ones.
    void endInput() { newest_ ^= 1; }
    /// Finishes the blocks that were begun before the last ones.
    /// out     see Bc6hFast::run; receives the blocks that are encoded
    /// errors  receives the mean squared error of each block [octaves^2], approximately; kLeft or infinity where it is not encoded
    HWY_INLINE void finish(std::uint32_t* out, float* errors) {
        const Blocks& blocks = blocks_[newest_ ^ 1];
        F error = leftError(blocks);
        if (!hn::AllFalse(D(), blocks.narrow)) error = blocks.areWeighted ? finish<true>(blocks, out) : finish<false>(blocks, out);
        hn::StoreU(error, D(), errors);
    }

private:
    /// Blocks under way, and what is known of them.
    struct Blocks {
        S half[3][kPairs];           ///< texels, as the bits of halves
        S counting[kPairs];          ///< all bits of the texels that count, if some do not
        M canCount, nothing;         ///< blocks whose weights are 0 and 1; insignificant blocks, all of whose texels count
        F perTexelCount;             ///< 1 over the number of the texels that count
        F low[3], range[3], widest;  ///< of the channels, in halves
        S lowest[3];
        M narrow, even, unreliable;  ///< blocks to encode; those whose texels have the same weight; those that need the full search
        bool allCount, areWeighted;
        F perHalf, unit;    ///< units of d in a half, and its inverse
        S d[3][kPairs];     ///< distances of the texels from the lowest value, kRange at most
        S weight[kPairs];   ///< of the texels, kWeight at most
        F count, perCount;  ///< sum of the weights, over kWeight, and its inverse
        F perShare;         ///< square of the largest slope over the slope at the mean
        F channelWeight[3];
        F sum[3], product[6];  ///< sums of d; covariance
        F axis[3];
        F lowV[3];    ///< lowest value, in v
        F oneColour;  ///< error of the mean colour
        Bc6hFastLineEnds<D> line;
        Bc6hFastBlock<D, false> codes;
    };
    static constexpr int kRange = 8191;    ///< largest distance of a texel from the lowest value of a channel
    static constexpr float kSteepest = 8;  ///< largest ratio of the slopes of the metric in a channel
    static constexpr float kEven = 1.25f;  ///< ratio up to which all texels have the same weight
    static constexpr float kSlope = 8191;  ///< largest slope in weigh()
    static constexpr int kWeight = 512;    ///< weight of the texels of blocks that are even
    static constexpr float kStep = 128;    ///< units to a step between neighbouring indices
    static constexpr int kLastStep = 16 * 128 - 1;
    static constexpr int kDiagonal[3] = {0, 3, 5};  ///< of a covariance
    static constexpr float kReach = 32;             ///< smallest distance above a texel at which its slope is taken [halves]
    static constexpr float kLinearScale = 0x1p40f;  ///< scale_ of a linear metric: x + scale is the scale
    static constexpr float kLargestHalf = 0x7BFF;
    // The same limits of a reliable estimate as in fast-inl.h, in halves.
    static constexpr float kWide = 4096, kWideElsewhere = 1024, kDark = 2048, kDarkRange = 16;

    /// Loads texels as the bits of halves. half[c][pair] holds texels t and t + 4, rows 0 and 1 first.
    static HWY_INLINE bool load(const std::array<const float*, 4>& rows, Blocks& blocks) {
        const DS ds;
        const D d;
        S least = hn::Zero(ds), most = hn::Zero(ds);
        for (std::size_t two = 0; two < 4; ++two) {  // two texels of a row in each part of 128 bits
            const std::size_t row = two / 2 * 2, column = two % 2 * 2;
            S lower[4], upper[4];
            for (std::size_t block = 0; block < 4; ++block) {
                const S first = halvesOf(ds, rows[row] + 16 * block + 4 * column);
                const S second = halvesOf(ds, rows[row + 1] + 16 * block + 4 * column);
                least = hn::Min(least, hn::Min(first, second));
                most = hn::Max(most, hn::Max(first, second));
                lower[block] = hn::InterleaveLower(ds, first, second);
                upper[block] = hn::InterleaveUpper(ds, first, second);
            }
            const std::size_t pair = 4 * (row / 2) + column;
            transpose(d, lower, pair, blocks);
            transpose(d, upper, pair + 1, blocks);
        }
        if (hn::AllFalse(ds, hn::Or(least<hn::Zero(ds), most> setBoth(0x7BFE)))) return false;
        for (auto& channel : blocks.half)
            for (S& pair : channel) pair = hn::Min(hn::Max(pair, hn::Zero(ds)), setBoth(0x7BFF));
        return isOutside(rows);
    }
    /// Returns true if a value is outside of the range of the format.
    HWY_NOINLINE static bool isOutside(const std::array<const float*, 4>& rows) {
        bool outside = false;
        for (const float* row : rows)
            for (std::size_t x = 0; x < 4 * hn::MaxLanes(D()); ++x)
                for (std::size_t c = 0; c < 3; ++c) outside |= row[4 * x + c] < 0 || row[4 * x + c] > 65504;
        return outside;
    }
    /// Loads two texels in each part of 128 bits, as the bits of halves: those at from + 64 i, i the index of the part.
    template <class DSn>
    static HWY_INLINE hn::Vec<DSn> halvesOf(DSn ds, const float* from) {
        if constexpr (hn::MaxLanes(DSn()) == 8) {
#if HWY_ARCH_X86 && HWY_MAX_BYTES >= 32
            const hn::CappedTag<float, 8> d8;
            return hn::BitCast(ds, hn::DemoteTo(hn::Rebind<hwy::float16_t, decltype(d8)>(), hn::LoadU(d8, from)));
#else
            const hn::CappedTag<float, 4> d4;
            const hn::Rebind<hwy::float16_t, decltype(d4)> dh;
            const hn::Half<DSn> half;
            return hn::Combine(ds, hn::BitCast(half, hn::DemoteTo(dh, hn::LoadU(d4, from + 4))),
                               hn::BitCast(half, hn::DemoteTo(dh, hn::LoadU(d4, from))));
#endif
        } else {
            const hn::Half<DSn> half;
            return hn::Combine(ds, halvesOf(half, from + hn::MaxLanes(half) / 8 * 64), halvesOf(half, from));
        }
    }
    /// Transposes four vectors of pairs, whose parts of 128 bits hold the channels of a block, into one for each channel.
    static HWY_INLINE void transpose(D d, const S (&block)[4], std::size_t pair, Blocks& blocks) {
        const hn::Repartition<double, D> dd;
        const auto wide = [&](S a) { return hn::BitCast(d, a); };
        const auto redGreen01 = hn::BitCast(dd, hn::InterleaveLower(d, wide(block[0]), wide(block[1])));
        const auto redGreen23 = hn::BitCast(dd, hn::InterleaveLower(d, wide(block[2]), wide(block[3])));
        const auto blue01 = hn::BitCast(dd, hn::InterleaveUpper(d, wide(block[0]), wide(block[1])));
        const auto blue23 = hn::BitCast(dd, hn::InterleaveUpper(d, wide(block[2]), wide(block[3])));
        blocks.half[0][pair] = hn::BitCast(DS(), hn::InterleaveLower(dd, redGreen01, redGreen23));
        blocks.half[1][pair] = hn::BitCast(DS(), hn::InterleaveUpper(dd, redGreen01, redGreen23));
        blocks.half[2][pair] = hn::BitCast(DS(), hn::InterleaveLower(dd, blue01, blue23));
    }

    /// Sets the texels that count.
    static void loadCounting(const std::array<const float*, 4>& rows, Blocks& blocks) {
        const DI di;
        M fits = zero() == zero(), all = fits;
        blocks.nothing = fits;
        I counting[kTexelCount];
        for (std::size_t y = 0; y < 4; ++y) {
            F w[4];
            hn::LoadInterleaved4(D(), rows[y], w[0], w[1], w[2], w[3]);
            for (std::size_t x = 0; x < 4; ++x) {
                const M isOne = w[x] == set(1.0f);
                fits = hn::And(fits, hn::Or(isOne, w[x] == zero()));
                all = hn::And(all, isOne);
                blocks.nothing = hn::And(blocks.nothing, w[x] == zero());
                counting[4 * y + x] = hn::VecFromMask(di, hn::RebindMask(di, isOne));
            }
        }
        blocks.canCount = fits;
        blocks.allCount = hn::AllTrue(D(), hn::Or(all, blocks.nothing));
        const I nothing = hn::VecFromMask(di, hn::RebindMask(di, blocks.nothing));
        I texelCount = hn::Zero(di);
        for (I& counts : counting) {
            counts = hn::Or(counts, nothing);
            texelCount = texelCount - counts;
        }
        blocks.perTexelCount = set(1.0f) / hn::ConvertTo(D(), texelCount);
        for (std::size_t pair = 0; pair < kPairs; ++pair) {
            const std::size_t t = pair / 4 * 8 + pair % 4;
            blocks.counting[pair] = inPairs(counting[t], counting[t + 4]);
        }
    }

    static HWY_INLINE void countAll(Blocks& blocks) {
        blocks.allCount = true;
        blocks.canCount = zero() == zero();
        blocks.nothing = zero() > zero();
        blocks.perTexelCount = set(1.0f / kTexelCount);
    }

    /// Returns the light of a half.
    static HWY_INLINE F lightAt(F half) {
        return hn::BitCast(D(), hn::ConvertTo(DI(), hn::Min(half, set(kLargestHalf)) * set(8192.0f))) * set(0x1p112f);
    }
    /// Returns the slope of the metric at a half, over a constant.
    HWY_INLINE F slopeAt(F half) const {
        const F x = lightAt(half);
        return x * roughInverse<D>(x + set(scale_));
    }
    static HWY_INLINE F lowOf(S pair) {
        return hn::ConvertTo(D(), hn::And(hn::BitCast(DI(), pair), hn::Set(DI(), 0xFFFF)));
    }

    /// Sets the range of each channel, the blocks to encode, and those in which all texels have the same weight.
    HWY_INLINE void measureRanges(Blocks& blocks) const {
        F dimmest = set(kLargestHalf), widest = set(1.0f);
        M narrow = blocks.canCount, even = zero() == zero();
        for (int c = 0; c < 3; ++c) {
            const auto& half = blocks.half[c];
            S least = half[0], most = least;
            if (blocks.allCount) {
                for (std::size_t pair = 1; pair < kPairs; ++pair) {
                    least = hn::Min(least, half[pair]);
                    most = hn::Max(most, half[pair]);
                }
            } else {
                least = setBoth(0x7FFF);
                most = hn::Zero(DS());
                for (std::size_t pair = 0; pair < kPairs; ++pair) {
                    least = hn::Min(least, hn::Or(half[pair], hn::AndNot(blocks.counting[pair], setBoth(0x7FFF))));
                    most = hn::Max(most, hn::And(half[pair], blocks.counting[pair]));
                }
            }
            blocks.lowest[c] = minInBoth(least);
            const F low = lowOf(blocks.lowest[c]), high = lowOf(maxInBoth(most)), range = high - low;
            blocks.low[c] = low;
            blocks.range[c] = range;
            widest = hn::Max(widest, range);
            dimmest = hn::Min(dimmest, low);
            const F reach = hn::MulAdd(range, set(1.0f / 16), set(kReach));
            const F dim = lightAt(low + reach), bright = lightAt(high + reach);
            const F flat = dim * (bright + set(scale_)), steep = bright * (dim + set(scale_));
            narrow = hn::And(narrow, steep <= flat * set(kSteepest));
            even = hn::And(even, steep <= flat * set(kEven));
        }
        const M unreliable = hn::Or(hn::And(dimmest<set(kDark), widest> set(kDarkRange)), widest > set(widest_));
        blocks.widest = widest;
        blocks.unreliable = unreliable;
        blocks.narrow = hn::AndNot(unreliable, narrow);
        blocks.even = even;
    }

    /// Sets the weights of the texels, kWeight at most: the square of the slope of the metric at the mean of the channels, as a quadratic
    /// function of this mean. The square of the largest slope is the unit.
    HWY_INLINE void weigh(Blocks& blocks, F& lowMean, F& perSteepest) const {
        const auto& d = blocks.d;
        const DS ds;
        const F reach = hn::MulAdd((blocks.range[0] + blocks.range[1]) + blocks.range[2], set(1.0f / 48), set(kReach));
        lowMean = hn::MulAdd((blocks.low[0] + blocks.low[1]) + blocks.low[2], set(1.0f / 3), reach);
        const F sum = hn::Max((blocks.range[0] + blocks.range[1]) + blocks.range[2], set(1.0f)), half = sum * set(1.0f / 6);
        const F first = slopeAt(lowMean), middle = slopeAt(lowMean + half), last = slopeAt(hn::MulAdd(set(2.0f), half, lowMean));
        perSteepest = set(1.0f) / last;
        const F from = first * perSteepest, through = middle * perSteepest;
        const F length = sum * blocks.perHalf, times = hn::Floor(set(32767.0f) / length), perLast = set(32768.0f) / (length * times);
        const F one = set(1.0f), four = set(4.0f);
        const F linear = hn::MulSub(four, through, hn::MulAdd(set(3.0f), from, one)) * perLast;
        const F square = hn::NegMulAdd(four, through, from + from + (one + one)) * (perLast * perLast);
        const auto inUnits = [&](F value, F evenly) {
            return inBoth(lowBitsOf(clamp(select(blocks.even, evenly, value * set(kSlope)), set(-32767.0f), set(32767.0f))));
        };
        const S c0 = inUnits(from, set(kSlope)), c1 = inUnits(linear, zero()), c2 = inUnits(square, zero());
        const S factor = inBoth(lowBitsOf(times));
        S total = hn::Zero(ds);
        for (std::size_t pair = 0; pair < kPairs; ++pair) {
            const S at = (d[0][pair] + (d[1][pair] + d[2][pair])) * factor;
            const S slope = c0 + hn::MulFixedPoint15(at, c1 + hn::MulFixedPoint15(at, c2));
            const S bounded = hn::ShiftLeft<1>(hn::Min(hn::Max(slope, hn::Zero(ds)), setBoth(static_cast<int>(kSlope))));
            blocks.weight[pair] = hn::ShiftRight<4>(hn::MulFixedPoint15(bounded, bounded) + setBoth(8));
            if (!blocks.allCount) blocks.weight[pair] = hn::And(blocks.weight[pair], blocks.counting[pair]);
            total = total + blocks.weight[pair];
        }
        blocks.count = hn::ConvertTo(D(), mulPairs(total, setBoth(1))) * set(1.0f / kWeight);
    }

    /// Returns the errors of blocks that are not encoded: infinity for those that the kernel in floats would not encode well either.
    static HWY_INLINE F leftError(const Blocks& blocks) {
        return select(blocks.unreliable, set(std::numeric_limits<float>::infinity()), set(kLeft));
    }

    /// Sets the distances, the weights, and the principal axis of the texels.
    template <bool kWeighted>
    HWY_INLINE void findAxis(Blocks& blocks) const {
        blocks.perHalf = hn::Floor(set(static_cast<float>(kRange)) / blocks.widest);
        blocks.unit = set(1.0f) / blocks.perHalf;
        const S factor = inBoth(lowBitsOf(blocks.perHalf));
        for (int c = 0; c < 3; ++c)
            for (std::size_t pair = 0; pair < kPairs; ++pair) blocks.d[c][pair] = (blocks.half[c][pair] - blocks.lowest[c]) * factor;
        S weighted[3][kPairs];
        F lowMean, perSteepest;
        if constexpr (kWeighted) {
            weigh(blocks, lowMean, perSteepest);
            blocks.perCount = set(1.0f) / blocks.count;
            for (std::size_t pair = 0; pair < kPairs; ++pair) {
                const S half = hn::ShiftLeft<5>(blocks.weight[pair]), whole = hn::SaturatedAdd(half, half);
                for (int c = 0; c < 3; ++c) weighted[c][pair] = hn::MulFixedPoint15(blocks.d[c][pair], whole);
            }
        } else {
            blocks.count = set(static_cast<float>(kTexelCount));
            blocks.perCount = set(1.0f / kTexelCount);
        }
        const auto& wd = kWeighted ? weighted : blocks.d;
        F root[3], meanOfChannels = zero();
        for (int c = 0; c < 3; ++c) {
            blocks.sum[c] = hn::ConvertTo(D(), sumOf(wd[c]));
            const F mean = blocks.sum[c] * blocks.perCount * blocks.unit;
            meanOfChannels = hn::MulAdd(mean, set(1.0f / 3), meanOfChannels);
            root[c] = slopeAt(mean + (blocks.low[c] + set(kReach))) * set(rootWeight_[static_cast<std::size_t>(c)]);
            blocks.channelWeight[c] = root[c] * root[c];
        }
        if constexpr (kWeighted) {
            const F share = slopeAt(meanOfChannels + lowMean) * perSteepest;  // of the largest slope
            blocks.perShare = select(blocks.even, set(1.0f), set(1.0f) / (share * share));
        }
        F covariance[6];
        constexpr int kRow[6] = {0, 0, 0, 1, 1, 2}, kColumn[6] = {0, 1, 2, 1, 2, 2};
        for (int i = 0; i < 6; ++i) {
            const F products = hn::ConvertTo(D(), dot(wd[kRow[i]], blocks.d[kColumn[i]]));
            blocks.product[i] = hn::NegMulAdd(blocks.sum[kRow[i]] * blocks.perCount, blocks.sum[kColumn[i]], products);
            covariance[i] = blocks.product[i] * (root[kRow[i]] * root[kColumn[i]]);
        }
        blocks.oneColour = zero();
        for (int c = 0; c < 3; ++c) blocks.oneColour = hn::MulAdd(blocks.channelWeight[c], blocks.product[kDiagonal[c]], blocks.oneColour);
        // The largest eigenvalue is a third of the trace or more, so that powers of the matrix over the trace do not vanish.
        const F perTrace = roughInverse<D>(hn::Max((covariance[0] + covariance[3]) + covariance[5], set(1e-30f)));
        for (F& m : covariance) m = m * perTrace;
        F axis[3];
        powerIteration<D>(covariance, 3, axis, [] {});
        for (int c = 0; c < 3; ++c) blocks.axis[c] = axis[c] * root[c];
    }

    /// Computes the least-squares line through the nearest of sixteen steps between the outermost projections, and rounds its ends.
    template <bool kWeighted>
    HWY_INLINE void fitLine(Blocks& blocks) const {
        const DS ds;
        const auto& axis = blocks.axis;
        const F longest = hn::Max(hn::Max(hn::Abs(axis[0]), hn::Abs(axis[1])), hn::Max(hn::Abs(axis[2]), set(1e-30f)));
        S along[kPairs];
        project(blocks.d, axis, set(32700.0f) / longest, along);
        S least = setBoth(0x7FFF), most = setBoth(-0x8000);
        for (std::size_t pair = 0; pair < kPairs; ++pair) {
            if (kWeighted && !blocks.allCount) {
                const auto counts = hn::MaskFromVec(blocks.counting[pair]);
                least = hn::Min(least, hn::IfThenElse(counts, along[pair], setBoth(0x7FFF)));
                most = hn::Max(most, hn::IfThenElse(counts, along[pair], setBoth(-0x8000)));
            } else {
                least = hn::Min(least, along[pair]);
                most = hn::Max(most, along[pair]);
            }
        }
        least = minInBoth(least);
        most = maxInBoth(most);
        const F length = hn::Max(lowOf(most - least), set(1.0f));
        const S perStep = inBoth(lowBitsOf(hn::Min(set(15 * kStep * 32768) / length, set(32767.0f))));
        S index[kPairs];
        for (std::size_t pair = 0; pair < kPairs; ++pair) {
            const S at = hn::MulFixedPoint15(along[pair] - least, perStep) + setBoth(static_cast<int>(kStep) / 2);
            index[pair] = hn::ShiftRight<7>(kWeighted ? hn::Min(hn::Max(at, hn::Zero(ds)), setBoth(kLastStep)) : at);
        }
        F k, kk, kd[3];
        sumSteps<kWeighted>(index, blocks, k, kk, kd);
        const F perVariance = set(1.0f) / hn::Max(hn::NegMulAdd(k * blocks.perCount, k, kk), set(1e-6f));
        const F vUnit = blocks.unit * set(Values::kPerHalf);
        for (int c = 0; c < 3; ++c) {
            blocks.lowV[c] = hn::MulAdd(blocks.low[c], set(Values::kPerHalf), set(Values::kPerHalf / 2));
            const F slope = hn::NegMulAdd(k * blocks.perCount, blocks.sum[c], kd[c]) * perVariance;
            const F first = hn::NegMulAdd(slope, k, blocks.sum[c]) * blocks.perCount, last = hn::MulAdd(slope, set(15.0f), first);
            // Clamp the ends near the range of the block, as in fast_line-inl.h.
            const F slack = blocks.range[c] * blocks.perHalf * set(0.25f), farthest = hn::MulAdd(slack, set(4.0f), slack);
            const auto inV = [&](F end) {
                const F v = hn::MulAdd(clamp(end, zero() - slack, farthest), vUnit, blocks.lowV[c]);
                return clamp(v, zero(), set(Values::kLargest));
            };
            blocks.line.a[c] = inV(first);
            blocks.line.d[c] = inV(last) - blocks.line.a[c];
        }
        blocks.codes.quantize(blocks.line);
    }

    /// Chooses the nearest indices between the rounded ends, and packs the blocks. Returns the errors.
    template <bool kWeighted>
    HWY_INLINE F finish(const Blocks& blocks, std::uint32_t* out) const {
        const F perV = blocks.perHalf * set(1.0f / Values::kPerHalf);
        F start[3], step[3], across[3], squared = set(1e-20f), offset = zero();
        for (int c = 0; c < 3; ++c) {
            start[c] = (blocks.line.a[c] - blocks.lowV[c]) * perV;
            step[c] = blocks.line.d[c] * perV * set(1.0f / 15);
            across[c] = blocks.channelWeight[c] * step[c];
            squared = hn::MulAdd(across[c], step[c], squared);
            offset = hn::MulAdd(across[c], start[c], offset);
        }
        const F perSquared = set(kStep) / squared;
        S along[kPairs], index[kPairs];
        project(blocks.d, across, perSquared * set(32768.0f), along);
        const S shift = inBoth(lowBitsOf(clamp(hn::NegMulAdd(offset, perSquared, set(kStep / 2)), set(-32767.0f), set(32767.0f))));
        for (std::size_t pair = 0; pair < kPairs; ++pair) {
            const S at = hn::SaturatedAdd(along[pair], shift);
            index[pair] = hn::ShiftRight<7>(hn::Min(hn::Max(at, hn::Zero(DS())), setBoth(kLastStep)));
        }
        blocks.codes.packIndices(index, out);
        F k, kk, kd[3], error = zero();
        sumSteps<kWeighted>(index, blocks, k, kk, kd);
        for (int c = 0; c < 3; ++c) {
            // The sum of (d - m - e - s k)^2, with m the mean of d, e = start - m, and s the step.
            const F e = hn::NegMulAdd(blocks.sum[c], blocks.perCount, start[c]);
            const F kAway = hn::NegMulAdd(k * blocks.perCount, blocks.sum[c], kd[c]);
            const F ofStep = step[c] * hn::MulAdd(step[c], kk, hn::MulSub(e + e, k, kAway + kAway));
            error = hn::MulAdd(blocks.channelWeight[c], blocks.product[kDiagonal[c]] + hn::MulAdd(e * blocks.count, e, ofStep), error);
        }
        error = hn::Max(error, zero());
        const F range = (blocks.range[0] + blocks.range[1]) + blocks.range[2];
        const M worse = hn::And(error > blocks.oneColour, range > zero());
        error = error * (blocks.unit * blocks.unit) * (blocks.perTexelCount * set(1 / (3 * 1024.0f * 1024.0f)));
        if constexpr (kWeighted) error = error * blocks.perShare;
        error = select(worse, set(std::numeric_limits<float>::infinity()), error);
        return select(blocks.narrow, hn::IfThenZeroElse(blocks.nothing, error), leftError(blocks));
    }

    /// Returns the sum over the channels of d times a factor, over 32768.
    static HWY_INLINE void project(const S (&d)[3][kPairs], const F (&axis)[3], F scale, S (&along)[kPairs]) {
        S factor[3];
        for (int c = 0; c < 3; ++c) factor[c] = inBoth(lowBitsOf(clamp(axis[c] * scale, set(-32767.0f), set(32767.0f))));
        for (std::size_t pair = 0; pair < kPairs; ++pair)
            along[pair] = hn::MulFixedPoint15(d[0][pair], factor[0]) +
                          (hn::MulFixedPoint15(d[1][pair], factor[1]) + hn::MulFixedPoint15(d[2][pair], factor[2]));
    }
    /// Sets the sums of k, k^2 and k d, by weight.
    template <bool kWeighted>
    static HWY_INLINE void sumSteps(const S (&index)[kPairs], const Blocks& blocks, F& k, F& kk, F (&kd)[3]) {
        S weighted[kPairs];
        if constexpr (kWeighted)
            for (std::size_t pair = 0; pair < kPairs; ++pair) weighted[pair] = index[pair] * blocks.weight[pair];
        const auto& wk = kWeighted ? weighted : index;
        const F perUnit = set(kWeighted ? 1.0f / kWeight : 1.0f);
        k = hn::ConvertTo(D(), kWeighted ? sumOf(wk) : smallSumOf(wk)) * perUnit;
        kk = hn::ConvertTo(D(), dot(wk, index)) * perUnit;
        for (int c = 0; c < 3; ++c) kd[c] = hn::ConvertTo(D(), dot(wk, blocks.d[c])) * perUnit;
    }

    float scale_;   ///< the slope of the metric at x is x / (x + scale), times a constant
    float widest_;  ///< range of a channel up to which an estimate of the error is reliable [halves]
    std::array<float, 3> rootWeight_;
    Blocks blocks_[2];
    unsigned newest_ = 0;
};

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
