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
