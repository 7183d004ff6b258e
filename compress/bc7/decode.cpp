// BC7 decoder after Khronos' Data Format Specification 1.3.
#include <utility>

#include "compress/bc7/modes.h"
#include "compress/block/decode.h"
#include "compress/block/partitions.h"

namespace lightcook::compress {
namespace {

struct Endpoints {
    int value[3][2][4];  ///< region, end, channel; eight bits
};

Endpoints readEndpoints(const Bc7Mode& mode, BitReader& bits) {
    Endpoints ends{};
    for (int c = 0; c < 3; ++c)
        for (int r = 0; r < mode.regionCount; ++r)
            for (int e = 0; e < 2; ++e) ends.value[r][e][c] = static_cast<int>(bits.get(mode.colourBits));
    if (mode.alphaBits)
        for (int r = 0; r < mode.regionCount; ++r)
            for (int e = 0; e < 2; ++e) ends.value[r][e][3] = static_cast<int>(bits.get(mode.alphaBits));
    const bool lowBits = mode.endpointLowBits || mode.sharedLowBits;
    for (int r = 0; r < mode.regionCount; ++r) {
        int low = mode.sharedLowBits ? static_cast<int>(bits.get(1)) : 0;
        for (int e = 0; e < 2; ++e) {
            if (mode.endpointLowBits) low = static_cast<int>(bits.get(1));
            for (int c = 0; c < 4; ++c) {
                const int stored = c < 3 ? mode.colourBits : mode.alphaBits;
                int& value = ends.value[r][e][c];
                if (stored == 0)
                    value = 255;
                else
                    value = lowBits ? expandTo8(value << 1 | low, stored + 1) : expandTo8(value, stored);
            }
        }
    }
    return ends;
}

std::array<int, kTexelCount> readIndices(int regionCount, int partition, int indexBits, BitReader& bits) {
    std::array<int, kTexelCount> indices;
    for (int t = 0; t < kTexelCount; ++t) {
        const bool anchor = t == anchorOf(regionCount, partition, regionOf(regionCount, partition, t));
        indices[static_cast<std::size_t>(t)] = static_cast<int>(bits.get(indexBits - anchor));
    }
    return indices;
}

}  // namespace

void decodeBc7(const std::byte* block, DecodedBlock& out) {
    out.fill(glm::vec4(0));
    BitReader bits(block, 16);
    int modeIndex = 0;
    while (modeIndex < 8 && bits.get(1) == 0) ++modeIndex;
    if (modeIndex == 8) return;  // reserved
    const Bc7Mode& mode = kBc7Modes[static_cast<std::size_t>(modeIndex)];
    const int partition = static_cast<int>(bits.get(mode.partitionBits));
    const std::uint32_t rotation = bits.get(mode.rotationBits), indexSelection = bits.get(mode.indexSelectionBits);
    const Endpoints ends = readEndpoints(mode, bits);
    auto colourIndices = readIndices(mode.regionCount, partition, mode.indexBits, bits);
    auto alphaIndices = colourIndices;
    int colourIndexBits = mode.indexBits, alphaIndexBits = mode.indexBits;
    if (mode.secondIndexBits) {
        alphaIndices = readIndices(1, 0, mode.secondIndexBits, bits);
        alphaIndexBits = mode.secondIndexBits;
        if (indexSelection) {
            std::swap(colourIndices, alphaIndices);
            std::swap(colourIndexBits, alphaIndexBits);
        }
    }
    for (int t = 0; t < kTexelCount; ++t) {
        const auto i = static_cast<std::size_t>(t);
        const auto& region = ends.value[regionOf(mode.regionCount, partition, t)];
        for (int c = 0; c < 4; ++c) {
            const int w = c < 3 ? weightOf(colourIndexBits, colourIndices[i]) : weightOf(alphaIndexBits, alphaIndices[i]);
            out[i][c] = static_cast<float>((region[0][c] * (64 - w) + region[1][c] * w + 32) >> 6) / 255;
        }
        if (rotation) std::swap(out[i].a, out[i][static_cast<int>(rotation) - 1]);
    }
}

}  // namespace lightcook::compress
