// Decoders of BC1, BC3, BC4 and BC5 after Direct3D 11 and Khronos' Data Format Specification, interpolated in real numbers.
#include "compress/block/decode.h"

#include <algorithm>
#include <cassert>
#include <glm/vec3.hpp>

namespace lightcook::compress {
namespace {

glm::vec3 colourFrom565(std::uint32_t packed) {
    return {static_cast<float>(packed >> 11) / 31, static_cast<float>((packed >> 5) & 63) / 63, static_cast<float>(packed & 31) / 31};
}

}  // namespace

void decodeBc1(const std::byte* block, bool alwaysFourColours, DecodedBlock& out) {
    BitReader bits(block, 8);
    const std::uint32_t first = bits.get(16), second = bits.get(16);
    std::array<glm::vec3, 4> palette;
    palette[0] = colourFrom565(first);
    palette[1] = colourFrom565(second);
    if (alwaysFourColours || first > second) {
        palette[2] = (2.0f * palette[0] + palette[1]) / 3.0f;
        palette[3] = (palette[0] + 2.0f * palette[1]) / 3.0f;
    } else {
        palette[2] = (palette[0] + palette[1]) / 2.0f;
        palette[3] = glm::vec3(0);
    }
    for (glm::vec4& texel : out) texel = glm::vec4(palette[bits.get(2)], 1);
}

namespace {

/// Reads the indices of a block and returns its values.
/// falls           the byte of the first endpoint is larger: seven steps between the endpoints, else five steps and the extremes
/// least, largest  extremes of the format
std::array<float, kTexelCount> interpolated(BitReader& bits, float first, float second, bool falls, float least, float largest) {
    std::array<float, 8> palette = {first, second};
    const int steps = falls ? 7 : 5;
    for (int i = 1; i < steps; ++i)
        palette[static_cast<std::size_t>(i + 1)] =
            (static_cast<float>(steps - i) * first + static_cast<float>(i) * second) / static_cast<float>(steps);
    if (!falls) {
        palette[6] = least;
        palette[7] = largest;
    }
    std::array<float, kTexelCount> out;
    for (float& value : out) value = palette[bits.get(3)] / largest;
    return out;
}

/// Decodes a signed channel. Byte -128 means -127, but the mode depends on the bytes as they are.
std::array<float, kTexelCount> decodeSnormChannel(const std::byte* block) {
    BitReader bits(block, 8);
    const int first = static_cast<std::int8_t>(bits.get(8)), second = static_cast<std::int8_t>(bits.get(8));
    return interpolated(bits, static_cast<float>(std::max(first, -127)), static_cast<float>(std::max(second, -127)), first > second, -127,
                        127);
}

}  // namespace

std::array<float, kTexelCount> decodeBc4Channel(const std::byte* block) {
    BitReader bits(block, 8);
    const std::uint32_t first = bits.get(8), second = bits.get(8);
    return interpolated(bits, static_cast<float>(first), static_cast<float>(second), first > second, 0, 255);
}

void decodeBc3(const std::byte* block, DecodedBlock& out) {
    decodeBc1(block + 8, true, out);
    const auto alpha = decodeBc4Channel(block);
    for (std::size_t t = 0; t < kTexelCount; ++t) out[t].a = alpha[t];
}

void decodeBc4(const std::byte* block, DecodedBlock& out) {
    const auto red = decodeBc4Channel(block);
    for (std::size_t t = 0; t < kTexelCount; ++t) out[t] = glm::vec4(red[t], 0, 0, 1);
}

void decodeBc5(const std::byte* block, DecodedBlock& out) {
    const auto red = decodeBc4Channel(block), green = decodeBc4Channel(block + 8);
    for (std::size_t t = 0; t < kTexelCount; ++t) out[t] = glm::vec4(red[t], green[t], 0, 1);
}

void decodeBc4Snorm(const std::byte* block, DecodedBlock& out) {
    const auto red = decodeSnormChannel(block);
    for (std::size_t t = 0; t < kTexelCount; ++t) out[t] = glm::vec4(red[t], 0, 0, 1);
}

void decodeBc5Snorm(const std::byte* block, DecodedBlock& out) {
    const auto red = decodeSnormChannel(block), green = decodeSnormChannel(block + 8);
    for (std::size_t t = 0; t < kTexelCount; ++t) out[t] = glm::vec4(red[t], green[t], 0, 1);
}

void decodeBlock(formats::PixelFormat format, const std::byte* block, DecodedBlock& out) {
    using formats::PixelFormat;
    switch (format) {
        case PixelFormat::Bc1:
            return decodeBc1(block, false, out);
        case PixelFormat::Bc3:
            return decodeBc3(block, out);
        case PixelFormat::Bc4:
            return decodeBc4(block, out);
        case PixelFormat::Bc4Snorm:
            return decodeBc4Snorm(block, out);
        case PixelFormat::Bc5:
            return decodeBc5(block, out);
        case PixelFormat::Bc5Snorm:
            return decodeBc5Snorm(block, out);
        case PixelFormat::Bc6hUf16:
            return decodeBc6h(block, false, out);
        case PixelFormat::Bc6hSf16:
            return decodeBc6h(block, true, out);
        case PixelFormat::Bc7:
            return decodeBc7(block, out);
        default:
            assert(false && "not a format of 4x4 BC blocks");
    }
}

}  // namespace lightcook::compress
