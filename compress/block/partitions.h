// The partitions of BC6H and BC7: the assignment of sixteen texels to two or three regions, each with a pair of endpoints.
// Source: the tables of Khronos' Data Format Specification 1.3, BPTC. BC6H uses the first 32 two-region partitions.
#pragma once

#include <array>
#include <cstdint>

namespace lightcook::compress {

/// Bit t is set if texel t belongs to region 1 of 2.
extern const std::array<std::uint16_t, 64> kTwoRegions;
/// Bits 2t and 2t + 1 are the region of texel t, 0 .. 2.
extern const std::array<std::uint32_t, 64> kThreeRegions;
/// The same for each of regions 1 and 2 of 3: bit t is set if texel t belongs to it.
extern const std::array<std::array<std::uint16_t, 64>, 2> kThreeRegionsMask;
/// The anchor of region 1 of 2: the texel whose index is stored without its highest bit. Texel 0 is the anchor of region 0.
extern const std::array<std::uint8_t, 64> kTwoRegionsAnchor;
/// The anchors of regions 1 and 2 of 3.
extern const std::array<std::array<std::uint8_t, 64>, 2> kThreeRegionsAnchor;

/// Interpolation weights of the second endpoint, in 64ths, for indices of 2, 3 and 4 bits.
extern const std::array<std::uint8_t, 4> kWeights2;
extern const std::array<std::uint8_t, 8> kWeights3;
extern const std::array<std::uint8_t, 16> kWeights4;

/// Returns the region of a texel, 0 .. regionCount - 1.
inline int regionOf(int regionCount, int partition, int texel) {
    if (regionCount == 1) return 0;
    const auto p = static_cast<std::size_t>(partition);
    return regionCount == 2 ? (kTwoRegions[p] >> texel) & 1 : static_cast<int>((kThreeRegions[p] >> (2 * texel)) & 3);
}
/// Returns the anchor texel of a region.
inline int anchorOf(int regionCount, int partition, int region) {
    if (region == 0) return 0;
    const auto p = static_cast<std::size_t>(partition);
    return regionCount == 2 ? kTwoRegionsAnchor[p] : kThreeRegionsAnchor[static_cast<std::size_t>(region - 1)][p];
}
/// Returns the interpolation weight of the second endpoint, in 64ths.
inline int weightOf(int indexBits, int index) {
    const auto i = static_cast<std::size_t>(index);
    return indexBits == 2 ? kWeights2[i] : indexBits == 3 ? kWeights3[i] : kWeights4[i];
}

}  // namespace lightcook::compress
