// BC6H decoder after Khronos' Data Format Specification 1.3. All steps are in integers, so the halves are exact.
#include <limits>

#include "compress/bc6h/modes.h"
#include "compress/block/decode.h"
#include "compress/block/partitions.h"
#include "compress/texel/half.h"

namespace lightcook::compress {
namespace {

int signExtend(int value, int bits) {
    return (value & (1 << (bits - 1))) ? value - (1 << bits) : value;
}

}  // namespace

void decodeBc6h(const std::byte* block, bool isSigned, DecodedBlock& out) {
    out.fill(glm::vec4(0, 0, 0, 1));
    BitReader bits(block, 16);
    const int modeIndex = bc6hModeOf(bits);
    if (modeIndex < 0) return;
    const Bc6hMode& mode = kBc6hModes[static_cast<std::size_t>(modeIndex)];
    int ends[4][3] = {};
    for (const Bc6hRun& run : bc6hRuns(modeIndex)) ends[run.end][run.channel] |= static_cast<int>(bits.get(run.bitCount)) << run.firstBit;
    const int partition = mode.regionCount == 2 ? static_cast<int>(bits.get(5)) : 0;
    for (int c = 0; c < 3; ++c) {
        if (isSigned) ends[0][c] = signExtend(ends[0][c], mode.endpointBits);
        for (int e = 1; e < 2 * mode.regionCount; ++e) {
            int& end = ends[e][c];
            if (mode.transformed)
                end = (ends[0][c] + signExtend(end, mode.deltaBits[static_cast<std::size_t>(c)])) & ((1 << mode.endpointBits) - 1);
            if (isSigned) end = signExtend(end, mode.endpointBits);
        }
        for (int e = 0; e < 2 * mode.regionCount; ++e) ends[e][c] = bc6hUnquantize(ends[e][c], mode.endpointBits, isSigned);
    }
    const int indexBits = mode.regionCount == 2 ? 3 : 4;
    const int secondAnchor = mode.regionCount == 2 ? anchorOf(2, partition, 1) : 0;
    for (int t = 0; t < kTexelCount; ++t) {
        const int region = regionOf(mode.regionCount, partition, t);
        const bool anchor = t == 0 || t == secondAnchor;
        const int w = weightOf(indexBits, static_cast<int>(bits.get(indexBits - anchor)));
        for (int c = 0; c < 3; ++c) {
            const int value = (ends[2 * region][c] * (64 - w) + ends[2 * region + 1][c] * w + 32) >> 6;
            const auto half = static_cast<std::uint16_t>(bc6hFinish(value, isSigned));
            // Only endpoints of -32768 give minus infinity, and our encoder never writes them.
            constexpr std::uint16_t kMinusInfinity = 0xFC00;
            out[static_cast<std::size_t>(t)][c] = half == kMinusInfinity ? -std::numeric_limits<float>::infinity() : floatFromHalf(half);
        }
    }
}

}  // namespace lightcook::compress
