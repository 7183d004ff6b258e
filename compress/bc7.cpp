#include <algorithm>
#include <cmath>

#include "compress/bc7_modes.h"
#include "compress/block.h"
#include "compress/partitions.h"

namespace compress {
namespace {

/// Mode 6: one region, four channels of eight bits whose low bit an endpoint's channels share.
void encodeMode6(const Block& block, const EncodeOptions& options, std::byte* out) {
    std::array<std::array<float, kTexelCount>, 4> code;
    float low[4], high[4];
    std::size_t widest = 0;
    for (std::size_t c = 0; c < 4; ++c) {
        low[c] = INFINITY;
        high[c] = -INFINITY;
        for (std::size_t t = 0; t < kTexelCount; ++t) {
            code[c][t] = block.channel[c][t] * 255;
            if (!(block.significance[t] > 0)) continue;
            low[c] = std::min(low[c], code[c][t]);
            high[c] = std::max(high[c], code[c][t]);
        }
        if (high[c] - low[c] > high[widest] - low[widest]) widest = c;
    }
    for (std::size_t c = 0; c < 4; ++c) {
        float covariance = 0, meanA = (low[widest] + high[widest]) / 2, meanB = (low[c] + high[c]) / 2;
        for (std::size_t t = 0; t < kTexelCount; ++t)
            covariance += block.significance[t] * (code[widest][t] - meanA) * (code[c][t] - meanB);
        if (covariance < 0) std::swap(low[c], high[c]);
    }
    int ends[2][4], lowBit[2];
    for (int e = 0; e < 2; ++e) {
        const float* target = e == 0 ? low : high;
        float best = INFINITY;
        for (int bit = 0; bit < 2; ++bit) {
            int trial[4];
            float error = 0;
            for (std::size_t c = 0; c < 4; ++c) {
                trial[c] = std::clamp(static_cast<int>((target[c] - static_cast<float>(bit)) / 2 + 0.5f), 0, 127);
                const float miss = static_cast<float>(trial[c] * 2 + bit) - target[c];
                error += options.channelWeights[c] * miss * miss;
            }
            if (error < best) {
                best = error;
                lowBit[e] = bit;
                std::copy_n(trial, 4, ends[e]);
            }
        }
    }
    std::array<int, kTexelCount> index;
    for (std::size_t t = 0; t < kTexelCount; ++t) {
        float best = INFINITY;
        for (int i = 0; i < 16; ++i) {
            float error = 0;
            for (std::size_t c = 0; c < 4; ++c) {
                const int w = weightOf(4, i), a = ends[0][c] * 2 + lowBit[0], b = ends[1][c] * 2 + lowBit[1];
                const float miss = static_cast<float>((a * (64 - w) + b * w + 32) >> 6) - code[c][t];
                error += options.channelWeights[c] * miss * miss;
            }
            if (error < best) best = error, index[t] = i;
        }
    }
    if (index[0] >= 8) {
        for (int& i : index) i = 15 - i;
        std::swap(ends[0], ends[1]);
        std::swap(lowBit[0], lowBit[1]);
    }
    BitWriter bits;
    bits.put(1u << 6, 7);
    for (int c = 0; c < 4; ++c)
        for (int e = 0; e < 2; ++e) bits.put(static_cast<std::uint32_t>(ends[e][c]), 7);
    for (int e = 0; e < 2; ++e) bits.put(static_cast<std::uint32_t>(lowBit[e]), 1);
    for (std::size_t t = 0; t < kTexelCount; ++t) bits.put(static_cast<std::uint32_t>(index[t]), t == 0 ? 3 : 4);
    bits.store(out, 16);
}

}  // namespace

void encodeBc7(std::span<const Block> blocks, const EncodeOptions& options, std::byte* out) {
    for (const Block& block : blocks) {
        encodeMode6(block, options, out);
        out += 16;
    }
}

}  // namespace compress
