// What comes before the indices of a BC7 block: the mode, the partition and the colours, without which texel shows which.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "compress/block/block.h"

namespace lightcook::compress {

/// One index a texel; texels of `anchors` store theirs without the highest bit.
struct IndexSet {
    int bits = 0;               ///< 2 .. 4
    std::uint16_t anchors = 0;  ///< bit t: texel t
    unsigned channels = 0;      ///< bit c: decoded channel c follows this set
};

struct BlockHead {
    int bits = 0;  ///< from the block's start; 0: a reserved mode
    int setCount = 0;
    std::array<IndexSet, 2> sets{};  ///< in the order in which they are stored
};

BlockHead headOfBc7(const std::byte* block);

/// Writes everything behind the head.
/// indices  of each set, 0 .. 2^bits - 1; of anchors below half of that
void putIndices(const BlockHead& head, std::span<const std::array<std::uint8_t, kTexelCount>, 2> indices, std::byte* block);

}  // namespace lightcook::compress
