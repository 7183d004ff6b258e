// The head of a BC6H or BC7 block: all bits before the indices, that is, the mode, the partition and the endpoints.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "compress/block/block.h"
#include "formats/pixel_format.h"

namespace lightcook::compress {

/// A set of one index per texel. Anchor texels store theirs without the highest bit.
struct IndexSet {
    int bits = 0;               ///< 2 .. 4
    std::uint16_t anchors = 0;  ///< bit t: texel t is an anchor
    unsigned channels = 0;      ///< bit c: this set interpolates decoded channel c
};

struct BlockHead {
    int bits = 0;  ///< size of the head; 0: none, or a reserved mode
    int setCount = 0;
    std::array<IndexSet, 2> sets{};  ///< in stored order
};

/// Reads the head of a BC6H or BC7 block. Blocks of other formats have none: 0 bits.
BlockHead headOf(formats::PixelFormat format, const std::byte* block);

/// Replaces the indices of a block.
/// indices  for each set, 0 .. 2^bits - 1, of anchors below 2^(bits - 1)
void putIndices(const BlockHead& head, std::span<const std::array<std::uint8_t, kTexelCount>, 2> indices, std::byte* block);

}  // namespace lightcook::compress
