#include <algorithm>
#include <cmath>

#include "compress/bc6h_modes.h"
#include "compress/block.h"
#include "compress/half.h"
#include "compress/partitions.h"

namespace compress {
namespace {

/// Mode 11: one region, ten bits, no deltas; the ends are the box of the texels along their longest axis.
void encodeMode11(const Block& block, bool isSigned, std::byte* out) {
    std::array<std::array<float, kTexelCount>, 3> bitsOf;
    float low[3], high[3];
    std::size_t widest = 0;
    for (std::size_t c = 0; c < 3; ++c) {
        low[c] = INFINITY;
        high[c] = -INFINITY;
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            const std::uint16_t half = halfFromFloat(block.channel[c][t]);
            const float magnitude = static_cast<float>(half & 0x7FFF);
            bitsOf[c][t] = half & 0x8000 ? -magnitude : magnitude;
            if (!(block.significance[t] > 0)) continue;
            low[c] = std::min(low[c], bitsOf[c][t]);
            high[c] = std::max(high[c], bitsOf[c][t]);
        }
        if (high[c] - low[c] > high[widest] - low[widest]) widest = c;
    }
    for (std::size_t c = 0; c < 3; ++c) {
        float covariance = 0, meanA = (low[widest] + high[widest]) / 2, meanB = (low[c] + high[c]) / 2;
        for (std::size_t t = 0; t < kTexelCount; ++t)
            covariance += block.significance[t] * (bitsOf[widest][t] - meanA) * (bitsOf[c][t] - meanB);
        if (covariance < 0) std::swap(low[c], high[c]);
    }
    int ends[2][3], values[2][3];
    for (int c = 0; c < 3; ++c)
        for (int e = 0; e < 2; ++e) {
            const float target = e == 0 ? low[c] : high[c];
            const float full = isSigned ? std::abs(target) * 32 / 31 / 64 : target * 64 / 31 / 64;
            const int code = std::min(static_cast<int>(full), isSigned ? 511 : 1023);
            ends[e][c] = target < 0 ? -code : code;
            values[e][c] = bc6hUnquantize(ends[e][c], 10, isSigned);
        }
    std::array<int, kTexelCount> index;
    for (std::size_t t = 0; t < kTexelCount; ++t) {
        float best = INFINITY;
        for (int i = 0; i < 16; ++i) {
            float error = 0;
            for (std::size_t c = 0; c < 3; ++c) {
                const int w = weightOf(4, i);
                const int value = (values[0][c] * (64 - w) + values[1][c] * w + 32) >> 6;
                const int finished = bc6hFinish(value, isSigned);
                const float signedBits = static_cast<float>(finished & 0x8000 ? -(finished & 0x7FFF) : finished);
                error += (signedBits - bitsOf[c][t]) * (signedBits - bitsOf[c][t]);
            }
            if (error < best) best = error, index[t] = i;
        }
    }
    if (index[0] >= 8) {
        for (int& i : index) i = 15 - i;
        for (int c = 0; c < 3; ++c) std::swap(ends[0][c], ends[1][c]);
    }
    BitWriter bits;
    bits.put(kBc6hModes[10].header, 5);
    for (const Bc6hBit& bit : bc6hLayout(10)) bits.put(static_cast<std::uint32_t>(ends[bit.end][bit.channel] >> bit.bit) & 1u, 1);
    for (std::size_t t = 0; t < kTexelCount; ++t) bits.put(static_cast<std::uint32_t>(index[t]), t == 0 ? 3 : 4);
    bits.store(out, 16);
}

}  // namespace

void encodeBc6h(std::span<const Block> blocks, bool isSigned, const EncodeOptions&, std::byte* out) {
    for (const Block& block : blocks) {
        encodeMode11(block, isSigned, out);
        out += 16;
    }
}

}  // namespace compress
