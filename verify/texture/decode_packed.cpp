// Formats without blocks. Sources: Khronos Data Format 1.3, chapters 10 (small floats) and 13 (sRGB); Vulkan 34.1 for the
// packings.
#include <array>
#include <cassert>
#include <cmath>

#include "verify/texture/decode.h"

namespace lightcook::verify {
namespace {

std::uint32_t load(std::span<const std::byte> bytes, std::size_t offset, std::size_t count) {
    std::uint32_t value = 0;
    for (std::size_t i = count; i-- > 0;) value = value << 8 | std::to_integer<std::uint32_t>(bytes[offset + i]);
    return value;
}

/// Decodes an unsigned float of 5 exponent bits: a half without sign bit and without the lowest mantissa bits.
float smallFloat(std::uint32_t bits, int mantissaBits) {
    return floatFromHalf(static_cast<std::uint16_t>(bits << (10 - mantissaBits)));
}

const std::array<float, 256>& linearFromSrgb() {
    static const std::array<float, 256> table = [] {
        std::array<float, 256> values{};
        for (int i = 0; i < 256; ++i) {
            const double encoded = i / 255.0;
            values[static_cast<std::size_t>(i)] =
                static_cast<float>(encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4));
        }
        return values;
    }();
    return table;
}

}  // namespace

glm::vec4 decodeRgb9e5(std::span<const std::byte, 4> texel) {
    const std::uint32_t bits = load(texel, 0, 4);
    const float scale = std::ldexp(1.0f, static_cast<int>(bits >> 27) - 15 - 9);
    return {static_cast<float>(bits & 511) * scale, static_cast<float>(bits >> 9 & 511) * scale,
            static_cast<float>(bits >> 18 & 511) * scale, 1.0f};
}

glm::vec4 decodeR11g11b10f(std::span<const std::byte, 4> texel) {
    const std::uint32_t bits = load(texel, 0, 4);
    return {smallFloat(bits & 0x7ff, 6), smallFloat(bits >> 11 & 0x7ff, 6), smallFloat(bits >> 22, 5), 1.0f};
}

glm::vec4 decodeHalfs(std::span<const std::byte> texel, int channelCount) {
    assert(channelCount <= 4 && texel.size() >= 2 * static_cast<std::size_t>(channelCount));
    glm::vec4 value(0.0f, 0.0f, 0.0f, 1.0f);
    for (int c = 0; c < channelCount; ++c)
        value[c] = floatFromHalf(static_cast<std::uint16_t>(load(texel, 2 * static_cast<std::size_t>(c), 2)));
    return value;
}

glm::vec4 decodeUnorm16(std::span<const std::byte> texel, int channelCount) {
    assert(channelCount <= 4 && texel.size() >= 2 * static_cast<std::size_t>(channelCount));
    glm::vec4 value(0.0f, 0.0f, 0.0f, 1.0f);
    for (int c = 0; c < channelCount; ++c) value[c] = static_cast<float>(load(texel, 2 * static_cast<std::size_t>(c), 2)) / 65535.0f;
    return value;
}

glm::vec4 decodeUnorm8(std::span<const std::byte, 4> texel) {
    glm::vec4 value;
    for (int c = 0; c < 4; ++c) value[c] = static_cast<float>(std::to_integer<int>(texel[static_cast<std::size_t>(c)])) / 255.0f;
    return value;
}

glm::vec4 decodeSrgb8(std::span<const std::byte, 4> texel) {
    glm::vec4 value = decodeUnorm8(texel);
    for (int c = 0; c < 3; ++c) value[c] = linearFromSrgb()[std::to_integer<std::size_t>(texel[static_cast<std::size_t>(c)])];
    return value;
}

}  // namespace lightcook::verify
