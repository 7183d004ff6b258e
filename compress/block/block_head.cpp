#include "compress/block/block_head.h"

#include <algorithm>
#include <cassert>

#include "compress/bc6h/modes.h"
#include "compress/bc7/modes.h"
#include "compress/block/partitions.h"

namespace lightcook::compress {
namespace {

std::uint16_t anchorsOf(int regionCount, int partition) {
    unsigned anchors = 0;
    for (int region = 0; region < regionCount; ++region) anchors |= 1u << anchorOf(regionCount, partition, region);
    return static_cast<std::uint16_t>(anchors);
}

BlockHead headOfBc6h(const std::byte* block) {
    BitReader bits(block, 16);
    const int modeIndex = bc6hModeOf(bits);
    if (modeIndex < 0) return {};
    BlockHead head;
    head.setCount = 1;
    if (kBc6hModes[static_cast<std::size_t>(modeIndex)].regionCount == 1) {
        head.bits = 65;
        head.sets[0] = {4, anchorsOf(1, 0), 0b1111};
        return head;
    }
    constexpr int kPartitionAt = 77;
    head.bits = kPartitionAt + 5;
    BitReader partition(block + kPartitionAt / 8, 2);
    partition.get(kPartitionAt % 8);
    head.sets[0] = {3, anchorsOf(2, static_cast<int>(partition.get(5))), 0b1111};
    return head;
}

BlockHead headOfBc7(const std::byte* block) {
    BitReader bits(block, 16);
    int modeIndex = 0;
    while (modeIndex < 8 && bits.get(1) == 0) ++modeIndex;
    if (modeIndex == 8) return {};
    const Bc7Mode& mode = kBc7Modes[static_cast<std::size_t>(modeIndex)];
    const int partition = static_cast<int>(bits.get(mode.partitionBits)), rotation = static_cast<int>(bits.get(mode.rotationBits));
    const bool isSwapped = bits.get(mode.indexSelectionBits) != 0;
    BlockHead head;
    head.bits = modeIndex + 1 + mode.partitionBits + mode.rotationBits + mode.indexSelectionBits +
                2 * mode.regionCount * (3 * mode.colourBits + mode.alphaBits + mode.endpointLowBits) +
                mode.regionCount * mode.sharedLowBits;
    head.setCount = mode.secondIndexBits ? 2 : 1;
    head.sets[0] = {mode.indexBits, anchorsOf(mode.regionCount, partition), 0b1111};
    if (head.setCount == 1) return head;
    // The separate channel is alpha, or the channel that rotation swaps with it.
    const unsigned alone = rotation ? 1u << (rotation - 1) : 1u << 3;
    head.sets[0].channels = isSwapped ? alone : 0b1111 & ~alone;
    head.sets[1] = {mode.secondIndexBits, anchorsOf(1, 0), 0b1111 & ~head.sets[0].channels};
    return head;
}

}  // namespace

BlockHead headOf(formats::PixelFormat format, const std::byte* block) {
    switch (format) {
        case formats::PixelFormat::Bc6hUf16:
        case formats::PixelFormat::Bc6hSf16:
            return headOfBc6h(block);
        case formats::PixelFormat::Bc7:
            return headOfBc7(block);
        default:
            return {};
    }
}

void putIndices(const BlockHead& head, std::span<const std::array<std::uint8_t, kTexelCount>, 2> indices, std::byte* block) {
    BitReader kept(block, 16);
    BitWriter out;
    for (int left = head.bits; left > 0; left -= 8) out.put(kept.get(std::min(left, 8)), std::min(left, 8));
    for (std::size_t s = 0; s < static_cast<std::size_t>(head.setCount); ++s)
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            const int bitCount = head.sets[s].bits - (head.sets[s].anchors >> t & 1);
            assert(indices[s][t] >> bitCount == 0);
            out.put(indices[s][t], bitCount);
        }
    out.store(block, 16);
}

}  // namespace lightcook::compress
