#include "compress/bc7/fast/pack.h"

#include "compress/bc7/modes.h"
#include "compress/block/block.h"
#include "compress/block/partitions.h"

namespace lightcook::compress {
namespace {

/// Repeats each of 16 bits twice.
constexpr std::uint64_t twice(std::uint64_t bits) {
    bits = (bits | bits << 8) & 0x00FF00FF;
    bits = (bits | bits << 4) & 0x0F0F0F0F;
    bits = (bits | bits << 2) & 0x33333333;
    bits = (bits | bits << 1) & 0x55555555;
    return 3 * bits;
}
/// Repeats each of 16 bits three times.
constexpr std::uint64_t thrice(std::uint64_t bits) {
    bits = (bits | bits << 16) & 0xFF00'00FF;
    bits = (bits | bits << 8) & 0xF0'0F00'F00F;
    bits = (bits | bits << 4) & 0xC30'C30C'30C3;
    bits = (bits | bits << 2) & 0x2492'4924'9249;
    return 7 * bits;
}
static_assert(twice(0x8001) == 0xC0000003 && thrice(0x8001) == 0xE000'0000'0007 && thrice(0xFFFF) == 0xFFFF'FFFF'FFFF);

constexpr std::uint64_t lowBits(int count) {
    return count >= 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << count) - 1;
}

/// Swaps two neighbouring fields of a word if `swap` is 1.
void swapFields(std::uint32_t& word, int position, int bits, std::uint32_t swap) {
    const std::uint32_t difference = ((word >> position) ^ (word >> (position + bits))) & ((1u << bits) - 1) & (0u - swap);
    word ^= difference << position | difference << (position + bits);
}

/// The indices of a block, with `bits` bits each.
struct IndexStream {
    std::uint64_t value;
    int bits;

    IndexStream(const std::array<std::uint32_t, 2>& words, int indexBits)
        : value(words[0] | static_cast<std::uint64_t>(words[1]) << (8 * indexBits)), bits(indexBits) {}
    int anchorBit(int texel) const { return bits * texel + bits - 1; }
    /// Returns 1 if the highest bit of this texel's index is set, and inverts the indices in the mask in that case.
    std::uint32_t turn(int anchor, std::uint64_t mask) {
        const std::uint64_t high = (value >> anchorBit(anchor)) & 1;
        value ^= mask & (0 - high);
        return static_cast<std::uint32_t>(high);
    }
    void removeAnchorBit(int texel) {
        const std::uint64_t below = lowBits(anchorBit(texel));
        value = (value & below) | ((value >> 1) & ~below);
    }
    void put(int anchorCount, BitWriter& out) const {
        const int count = kTexelCount * bits - anchorCount;
        out.put(static_cast<std::uint32_t>(value), count < 32 ? count : 32);
        if (count > 32) out.put(static_cast<std::uint32_t>(value >> 32), count - 32);
    }
};

}  // namespace

void packBc7(const Bc7Words& words, std::byte* out) {
    const Bc7Mode& mode = kBc7Modes[static_cast<std::size_t>(words.mode)];
    const bool separate = mode.secondIndexBits > 0;
    std::array<std::uint32_t, 4> code = words.code;
    std::uint32_t low = words.low;
    IndexStream index(words.index, mode.indexBits);
    const auto partition = static_cast<std::size_t>(words.partition);
    const std::uint64_t all = lowBits(kTexelCount * index.bits), regions = mode.regionCount == 1 ? 0 : kTwoRegions[partition],
                        second = index.bits == 2 ? twice(regions) : thrice(regions);
    for (int r = 0; r < mode.regionCount; ++r) {
        const std::uint32_t turned = index.turn(anchorOf(mode.regionCount, words.partition, r), r ? second : all & ~second);
        for (std::size_t c = 0; c < (separate ? 3u : 4u); ++c) swapFields(code[c], 2 * r * mode.colourBits, mode.colourBits, turned);
        if (mode.endpointLowBits) swapFields(low, 2 * r, 1, turned);
    }
    for (int r = mode.regionCount - 1; r >= 0; --r) index.removeAnchorBit(anchorOf(mode.regionCount, words.partition, r));

    BitWriter bits;
    bits.put(1u << words.mode, words.mode + 1);
    bits.put(static_cast<std::uint32_t>(words.partition), mode.partitionBits);
    bits.put(0, mode.rotationBits);
    for (std::size_t c = 0; c < 3; ++c) bits.put(code[c], 2 * mode.regionCount * mode.colourBits);
    if (!separate) {
        bits.put(code[3], 2 * mode.regionCount * mode.alphaBits);
        bits.put(low, mode.regionCount * (2 * mode.endpointLowBits + mode.sharedLowBits));
        index.put(mode.regionCount, bits);
    } else {
        IndexStream other(words.second, mode.secondIndexBits);
        swapFields(code[3], 0, mode.alphaBits, other.turn(0, lowBits(kTexelCount * other.bits)));
        other.removeAnchorBit(0);
        bits.put(code[3], 2 * mode.alphaBits);
        index.put(1, bits);
        other.put(1, bits);
    }
    bits.store(out, 16);
}

}  // namespace lightcook::compress
