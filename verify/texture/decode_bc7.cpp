// BC7. Source: Khronos Data Format 1.3, section 20.1; Direct3D 11.3 functional specification, BC7.
#include <array>
#include <utility>

#include "verify/texture/decode.h"

namespace lightcook::verify {
namespace {

struct Bc7Mode {
    int subsetCount, partitionBits, rotationBits, selectionBits, colourBits, alphaBits;
    int endpointPBits;  ///< one low bit for each endpoint, or
    int sharedPBits;    ///< one for both endpoints of a subset
    int indexBits, secondIndexBits;
};
constexpr std::array<Bc7Mode, 8> kBc7Modes = {{
    {3, 4, 0, 0, 4, 0, 1, 0, 3, 0},
    {2, 6, 0, 0, 6, 0, 0, 1, 3, 0},
    {3, 6, 0, 0, 5, 0, 0, 0, 2, 0},
    {2, 6, 0, 0, 7, 0, 1, 0, 2, 0},
    {1, 0, 2, 1, 5, 6, 0, 0, 2, 3},
    {1, 0, 2, 0, 7, 8, 0, 0, 2, 2},
    {1, 0, 0, 0, 7, 7, 1, 0, 4, 0},
    {2, 6, 0, 0, 5, 5, 1, 0, 2, 0},
}};

using Endpoint = std::array<std::uint32_t, 4>;
using Indices = std::array<std::uint8_t, 16>;

std::uint32_t expandTo8(std::uint32_t value, int bits) {
    value <<= 8 - bits;
    return value | value >> bits;
}

/// Endpoints 2 s and 2 s + 1 belong to subset s.
std::array<Endpoint, 6> readEndpoints(BlockBits& bits, const Bc7Mode& mode) {
    const std::size_t count = static_cast<std::size_t>(2 * mode.subsetCount);
    std::array<Endpoint, 6> endpoints{};
    for (std::size_t channel = 0; channel < 4; ++channel)
        for (std::size_t e = 0; e < count; ++e) endpoints[e][channel] = bits.take(channel < 3 ? mode.colourBits : mode.alphaBits);
    const int pBits = mode.endpointPBits | mode.sharedPBits;
    std::uint32_t p = 0;
    for (std::size_t e = 0; e < count; ++e) {
        if (mode.endpointPBits != 0 || (mode.sharedPBits != 0 && e % 2 == 0)) p = bits.take(1);
        for (std::size_t channel = 0; channel < 4; ++channel) {
            const int stored = channel < 3 ? mode.colourBits : mode.alphaBits;
            std::uint32_t& value = endpoints[e][channel];
            if (stored == 0)
                value = 255;  // modes without alpha are opaque
            else
                value = expandTo8(pBits != 0 ? value << 1 | p : value, stored + pBits);
        }
    }
    return endpoints;
}

Indices readIndices(BlockBits& bits, const Partition& partition, int subsetCount, int indexBits) {
    Indices indices;
    for (int texel = 0; texel < 16; ++texel) {
        bool isAnchor = texel == 0;
        for (int s = 1; s < subsetCount; ++s) isAnchor |= texel == partition.anchors[s];
        indices[static_cast<std::size_t>(texel)] = static_cast<std::uint8_t>(bits.take(indexBits - (isAnchor ? 1 : 0)));
    }
    return indices;
}

float interpolate(std::uint32_t a, std::uint32_t b, std::uint32_t weight) {
    return static_cast<float>(((64 - weight) * a + weight * b + 32) >> 6) / 255.0f;
}

}  // namespace

void decodeBc7(Block16 block, Texels4x4 out) {
    const unsigned head = std::to_integer<unsigned>(block[0]);
    if (head == 0) {
        for (glm::vec4& texel : out) texel = glm::vec4(0.0f);
        return;
    }
    const int modeIndex = std::countr_zero(head);
    const Bc7Mode& mode = kBc7Modes[static_cast<std::size_t>(modeIndex)];
    BlockBits bits(block);
    bits.take(modeIndex + 1);
    const Partition& partition = bptcPartition(mode.subsetCount, static_cast<int>(bits.take(mode.partitionBits)));
    const std::uint32_t rotation = bits.take(mode.rotationBits), selection = bits.take(mode.selectionBits);
    const std::array<Endpoint, 6> endpoints = readEndpoints(bits, mode);
    Indices colourIndices = readIndices(bits, partition, mode.subsetCount, mode.indexBits), alphaIndices = colourIndices;
    int colourIndexBits = mode.indexBits, alphaIndexBits = mode.indexBits;
    if (mode.secondIndexBits != 0) {
        alphaIndices = readIndices(bits, partition, 1, mode.secondIndexBits);
        alphaIndexBits = mode.secondIndexBits;
        if (selection != 0) {
            std::swap(colourIndices, alphaIndices);
            std::swap(colourIndexBits, alphaIndexBits);
        }
    }
    const std::span<const std::uint8_t> colourWeights = bptcWeights(colourIndexBits), alphaWeights = bptcWeights(alphaIndexBits);
    for (std::size_t texel = 0; texel < 16; ++texel) {
        const std::size_t e = 2 * static_cast<std::size_t>(partition.subset(static_cast<int>(texel)));
        const Endpoint &a = endpoints[e], &b = endpoints[e + 1];
        const std::uint32_t w = colourWeights[colourIndices[texel]], wAlpha = alphaWeights[alphaIndices[texel]];
        glm::vec4 value(interpolate(a[0], b[0], w), interpolate(a[1], b[1], w), interpolate(a[2], b[2], w),
                        interpolate(a[3], b[3], wAlpha));
        if (rotation == 1) std::swap(value.a, value.r);
        if (rotation == 2) std::swap(value.a, value.g);
        if (rotation == 3) std::swap(value.a, value.b);
        out[texel] = value;
    }
}

}  // namespace lightcook::verify
