// Loads rows of texels into lanes, one block in each lane, for kernels that do not gather blocks.
#if defined(LIGHTCOOK_COMPRESS_TEXEL_ROWS_INL_H_) == defined(HWY_TARGET_TOGGLE)
#ifdef LIGHTCOOK_COMPRESS_TEXEL_ROWS_INL_H_
#undef LIGHTCOOK_COMPRESS_TEXEL_ROWS_INL_H_
#else
#define LIGHTCOOK_COMPRESS_TEXEL_ROWS_INL_H_
#endif

#include <hwy/highway.h>

#include <algorithm>
#include <array>
#include <cstddef>

#include "compress/block/block.h"

HWY_BEFORE_NAMESPACE();
namespace lightcook::compress {
namespace HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

/// A copy of one block per lane at the edge of the image: texels beyond the edge repeat it and have weight 0.
template <std::size_t kLanes>
struct EdgeTexels {
    HWY_ALIGN float texels[4][16 * kLanes];
    HWY_ALIGN float weights[4][4 * kLanes];
    EdgeTexels(const TexelRows& rows, int left, int top) {
        for (int y = 0; y < 4; ++y)
            for (int x = 0; x < 4 * static_cast<int>(kLanes); ++x) {
                const bool inside = left + x < rows.width && top + y < rows.height;
                const int fromX = std::min(left + x, rows.width - 1), fromY = std::min(top + y, rows.height - 1);
                const float* from = rows.texels + fromY * rows.rowStride + 4 * fromX;
                std::copy_n(from, 4, texels[y] + 4 * x);
                const float weight = rows.significance ? rows.significance[fromY * rows.significanceStride + fromX] : 1.0f;
                weights[y][x] = inside ? weight : 0.0f;
            }
    }
};

/// Copies of any blocks, one per lane. Texels beyond the edge of the image repeat it and have weight 0.
template <std::size_t kLanes>
struct BlockTexels {
    HWY_ALIGN float texels[4][16 * kLanes];
    HWY_ALIGN float weights[4][4 * kLanes];
    bool areWeighted = false;  ///< false while all weights are 1

    /// Copies the block whose first texel is (left, top).
    void load(const TexelRows& rows, int left, int top, std::size_t lane) {
        const int columns = std::min(4, rows.width - left);
        areWeighted |= rows.significance || columns < 4 || top + 4 > rows.height;
        for (int y = 0; y < 4; ++y) {
            const int fromY = std::min(top + y, rows.height - 1);
            const float* from = rows.texels + fromY * rows.rowStride + 4 * left;
            float* to = texels[y] + 16 * lane;
            std::copy_n(from, 4 * columns, to);
            for (int x = columns; x < 4; ++x) std::copy_n(from + 4 * (columns - 1), 4, to + 4 * x);
            float* weight = weights[y] + 4 * lane;
            std::fill_n(weight, 4, 0.0f);
            if (top + y >= rows.height) continue;
            if (rows.significance)
                std::copy_n(rows.significance + fromY * rows.significanceStride + left, columns, weight);
            else
                std::fill_n(weight, columns, 1.0f);
        }
    }
};

/// Visits all blocks, row by row, a vector of blocks at a time.
/// run  is called with four rows of 4 Lanes(d) texels, four rows of significance or null for 1 everywhere, and the number of blocks that
///      lie in the image
template <class D, class Run>
void forEachVector(const TexelRows& rows, const Run& run) {
    constexpr int kLanes = static_cast<int>(hn::MaxLanes(D()));
    const int across = (rows.width + 3) / 4;
    for (int top = 0; top < rows.height; top += 4)
        for (int block = 0; block < across; block += kLanes) {
            const int left = 4 * block;
            const auto count = static_cast<std::size_t>(std::min(kLanes, across - block));
            std::array<const float*, 4> texels, weights;
            if (top + 4 <= rows.height && left + 4 * kLanes <= rows.width) {
                for (int y = 0; y < 4; ++y) {
                    texels[static_cast<std::size_t>(y)] = rows.texels + (top + y) * rows.rowStride + 4 * left;
                    weights[static_cast<std::size_t>(y)] =
                        rows.significance ? rows.significance + (top + y) * rows.significanceStride + left : nullptr;
                }
                run(texels, rows.significance ? &weights : nullptr, count);
            } else {
                const EdgeTexels<static_cast<std::size_t>(kLanes)> edge(rows, left, top);
                for (std::size_t y = 0; y < 4; ++y) {
                    texels[y] = edge.texels[y];
                    weights[y] = edge.weights[y];
                }
                run(texels, &weights, count);
            }
        }
}

/// Loads 128 bits of each of a vector's parts: the four floats at from + i * stride, i the index of the part.
template <class D>
HWY_INLINE hn::Vec<D> loadParts(D, const float* from, std::size_t stride) {
    if constexpr (hn::MaxLanes(D()) == 4) {
        return hn::LoadU(D(), from);
    } else {
        const hn::Half<D> half;
        return hn::Combine(D(), loadParts(half, from + hn::MaxLanes(half) / 4 * stride, stride), loadParts(half, from, stride));
    }
}

/// Loads one texel of each block, the four floats at from + 16 * lane, into the first kChannels channels.
template <class D, std::size_t kChannels>
HWY_INLINE void loadTexel(const float* from, std::array<hn::Vec<D>, kChannels>& channel) {
    const D d;
    if constexpr (hn::MaxLanes(D()) < 4) {
        HWY_ALIGN float values[kChannels][hn::MaxLanes(D())];
        for (std::size_t lane = 0; lane < hn::MaxLanes(d); ++lane)
            for (std::size_t c = 0; c < kChannels; ++c) values[c][lane] = from[16 * lane + c];
        for (std::size_t c = 0; c < kChannels; ++c) channel[c] = hn::Load(d, values[c]);
    } else {
        const hn::Repartition<double, D> pairs;
        const auto lower = [&](auto a, auto b) {
            return hn::BitCast(d, hn::InterleaveLower(pairs, hn::BitCast(pairs, a), hn::BitCast(pairs, b)));
        };
        const auto upper = [&](auto a, auto b) {
            return hn::BitCast(d, hn::InterleaveUpper(pairs, hn::BitCast(pairs, a), hn::BitCast(pairs, b)));
        };
        // Part i of vector j holds the texel of block 4 i + j: four texels by four channels, which are transposed within the parts.
        hn::Vec<D> texel[4];
        for (std::size_t j = 0; j < 4; ++j) texel[j] = loadParts(d, from + 16 * j, 64);
        const auto redGreen01 = hn::InterleaveLower(d, texel[0], texel[1]), redGreen23 = hn::InterleaveLower(d, texel[2], texel[3]);
        const auto blueAlpha01 = hn::InterleaveUpper(d, texel[0], texel[1]), blueAlpha23 = hn::InterleaveUpper(d, texel[2], texel[3]);
        channel[0] = lower(redGreen01, redGreen23);
        if constexpr (kChannels > 1) channel[1] = upper(redGreen01, redGreen23);
        if constexpr (kChannels > 2) channel[2] = lower(blueAlpha01, blueAlpha23);
        if constexpr (kChannels > 3) channel[3] = upper(blueAlpha01, blueAlpha23);
    }
}

/// Loads the texels of each block, clamped to [least, most], into planes of sixteen vectors, one for each of the first kChannels channels.
/// Returns true if a value was outside.
template <class D, std::size_t kChannels>
HWY_INLINE bool loadTexels(const std::array<const float*, 4>& rows, hn::Vec<D> least, hn::Vec<D> most,
                           const std::array<hn::Vec<D>*, kChannels>& planes) {
    const D d;
    auto low = least, high = most;
    for (std::size_t t = 0; t < kTexelCount; ++t) {
        std::array<hn::Vec<D>, kChannels> channel;
        loadTexel<D>(rows[t / 4] + 4 * (t % 4), channel);
        for (std::size_t c = 0; c < kChannels; ++c) planes[c][t] = channel[c];
        for (const auto* plane : planes) {
            low = hn::Min(low, plane[t]);
            high = hn::Max(high, plane[t]);
        }
    }
    if (hn::AllFalse(d, hn::Or(low<least, high> most))) return false;
    for (auto* plane : planes)
        for (std::size_t t = 0; t < kTexelCount; ++t) plane[t] = hn::Min(hn::Max(plane[t], least), most);
    return true;
}

/// Transposes a square of 128-bit parts: on return, part i of part[j] is what part j of part[i] was.
template <class D>
HWY_INLINE void transposeParts(D d, std::array<hn::Vec<D>, hn::MaxLanes(D()) / 4>& part) {
    if constexpr (hn::MaxLanes(D()) == 8) {
        const auto lower = hn::ConcatLowerLower(d, part[1], part[0]);
        part[1] = hn::ConcatUpperUpper(d, part[1], part[0]);
        part[0] = lower;
    }
#if HWY_TARGET <= HWY_AVX3
    if constexpr (hn::MaxLanes(D()) == 16) {
        using V = hn::Vec<D>;
        const V lower01 = hn::ConcatLowerLower(d, part[1], part[0]), upper01 = hn::ConcatUpperUpper(d, part[1], part[0]);
        const V lower23 = hn::ConcatLowerLower(d, part[3], part[2]), upper23 = hn::ConcatUpperUpper(d, part[3], part[2]);
        constexpr int kEven = 0x88, kOdd = 0xDD;  // parts 0 and 2, or 1 and 3, of both operands
        part[0] = V{_mm512_shuffle_f32x4(lower01.raw, lower23.raw, kEven)};
        part[1] = V{_mm512_shuffle_f32x4(lower01.raw, lower23.raw, kOdd)};
        part[2] = V{_mm512_shuffle_f32x4(upper01.raw, upper23.raw, kEven)};
        part[3] = V{_mm512_shuffle_f32x4(upper01.raw, upper23.raw, kOdd)};
    }
#endif
}

/// Loads one or two channels of the texels of each block into planes of sixteen vectors. Takes fewer shuffles than loadTexels() for them.
template <class D, std::size_t kChannels>
HWY_INLINE void loadChannels(const std::array<const float*, 4>& rows, const std::array<hn::Vec<D>*, kChannels>& planes) {
    static_assert(kChannels <= 2);
    const D d;
    constexpr std::size_t kLanes = hn::MaxLanes(D());
    if constexpr (kLanes < 4) {
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            std::array<hn::Vec<D>, kChannels> channel;
            loadTexel<D>(rows[t / 4] + 4 * (t % 4), channel);
            for (std::size_t c = 0; c < kChannels; ++c) planes[c][t] = channel[c];
        }
    } else {
        const hn::Repartition<double, D> pairs;
        // A vector holds kParts texels of one block, a part each. Four blocks are transposed within the parts, so that a part holds one
        // channel of one texel of the four; then the parts are transposed, so that a vector holds one texel of all blocks.
        constexpr std::size_t kParts = kLanes / 4;
        for (std::size_t first = 0; first < kTexelCount; first += kParts) {
            std::array<std::array<hn::Vec<D>, kParts>, kChannels> part;
            for (std::size_t four = 0; four < kParts; ++four) {
                const float* const from = rows[first / 4] + 4 * (first % 4) + 64 * four;
                hn::Vec<D> texel[4];
                for (std::size_t j = 0; j < 4; ++j) texel[j] = hn::LoadU(d, from + 16 * j);
                const auto both01 = hn::BitCast(pairs, hn::InterleaveLower(d, texel[0], texel[1]));
                const auto both23 = hn::BitCast(pairs, hn::InterleaveLower(d, texel[2], texel[3]));
                part[0][four] = hn::BitCast(d, hn::InterleaveLower(pairs, both01, both23));
                if constexpr (kChannels > 1) part[1][four] = hn::BitCast(d, hn::InterleaveUpper(pairs, both01, both23));
            }
            for (std::size_t c = 0; c < kChannels; ++c) {
                transposeParts(d, part[c]);
                for (std::size_t i = 0; i < kParts; ++i) planes[c][first + i] = part[c][i];
            }
        }
    }
}

/// Clamps one channel of each block to [least, most]. Returns true if a value was outside.
/// lowest, highest  receive the range of each block
template <class D>
HWY_INLINE bool clampTexels(hn::Vec<D> least, hn::Vec<D> most, hn::Vec<D>* plane, hn::Vec<D>& lowest, hn::Vec<D>& highest) {
    lowest = highest = plane[0];
    for (std::size_t t = 1; t < kTexelCount; ++t) {
        lowest = hn::Min(lowest, plane[t]);
        highest = hn::Max(highest, plane[t]);
    }
    if (hn::AllFalse(D(), hn::Or(lowest<least, highest> most))) return false;
    const auto clamp = [&](auto& value) { value = hn::Min(hn::Max(value, least), most); };
    for (std::size_t t = 0; t < kTexelCount; ++t) clamp(plane[t]);
    clamp(lowest);
    clamp(highest);
    return true;
}

/// Returns true if the significance of all texels of all blocks is 1.
template <class D>
bool areWeightsOne(const std::array<const float*, 4>& rows) {
    const D d;
    const auto one = hn::Set(d, 1.0f);
    auto isOne = hn::LoadU(d, rows[0]) == one;
    for (const float* row : rows)
        for (std::size_t i = 0; i < 4; ++i) isOne = hn::And(isOne, hn::LoadU(d, row + i * hn::MaxLanes(D())) == one);
    return hn::AllTrue(d, isOne);
}

/// Loads the significance of the texels of each block. Only ratios count; weights far from 1 are scaled by a power of two, so that sums of
/// squares neither overflow nor underflow. If all weights of a block are 0, they become 1 and `nothing` is set.
template <class D>
void loadWeights(const std::array<const float*, 4>& rows, hn::Vec<D> (&weight)[kTexelCount], hn::Mask<D>& nothing) {
    const hn::RebindToSigned<D> di;
    const auto set = [](float value) { return hn::Set(D(), value); };
    auto largest = set(0.0f);
    for (std::size_t y = 0; y < 4; ++y) {
        auto* w = weight + 4 * y;
        hn::LoadInterleaved4(D(), rows[y], w[0], w[1], w[2], w[3]);
        largest = hn::Max(largest, hn::Max(hn::Max(w[0], w[1]), hn::Max(w[2], w[3])));
    }
    nothing = hn::Not(largest > set(0.0f));
    const auto exponent = hn::And(hn::BitCast(di, largest), hn::Set(di, 0x7F800000));
    const auto power = hn::BitCast(D(), hn::Max(hn::Set(di, 0x7F000000) - exponent, hn::Set(di, 0x00800000)));
    const auto scale = hn::IfThenElse(hn::Or(largest<set(0x1p-10f), largest> set(0x1p10f)), power, set(1.0f));
    for (std::size_t t = 0; t < kTexelCount; ++t) weight[t] = hn::IfThenElse(nothing, set(1.0f), weight[t] * scale);
}

}  // namespace HWY_NAMESPACE
}  // namespace lightcook::compress
HWY_AFTER_NAMESPACE();
#endif
