// BC1, BC3, BC4, BC5. Source: Direct3D 11.3 functional specification, section 19.5, block compression formats.
#include <array>
#include <glm/vec3.hpp>

#include "verify/texture/decode.h"

namespace lightcook::verify {
namespace {

std::uint64_t load(Block8 block) {
    std::uint64_t bits = 0;
    for (std::size_t i = 8; i-- > 0;) bits = bits << 8 | std::to_integer<std::uint64_t>(block[i]);
    return bits;
}

glm::vec3 colour565(std::uint32_t bits) {
    return {static_cast<float>(bits >> 11 & 31) / 31.0f, static_cast<float>(bits >> 5 & 63) / 63.0f, static_cast<float>(bits & 31) / 31.0f};
}

/// Decodes the colour half of BC1 and BC3. Only BC1 has the mode of three colours and black.
/// blackAlpha  alpha of that black
void decodeColours(Block8 block, bool mayBeThreeColours, float blackAlpha, Texels4x4 out) {
    const std::uint64_t bits = load(block);
    const std::uint32_t first = bits & 0xffff, second = bits >> 16 & 0xffff;
    std::array<glm::vec3, 4> palette = {colour565(first), colour565(second)};
    float lastAlpha = 1.0f;
    if (first > second || !mayBeThreeColours) {
        palette[2] = (2.0f * palette[0] + palette[1]) / 3.0f;
        palette[3] = (palette[0] + 2.0f * palette[1]) / 3.0f;
    } else {
        palette[2] = (palette[0] + palette[1]) / 2.0f;
        palette[3] = glm::vec3(0.0f);
        lastAlpha = blackAlpha;
    }
    for (std::size_t texel = 0; texel < 16; ++texel) {
        const std::uint64_t index = bits >> (32 + 2 * texel) & 3;
        out[texel] = glm::vec4(palette[index], index == 3 ? lastAlpha : 1.0f);
    }
}

/// Decodes a BC4 block, which is also BC3's alpha and either half of BC5.
std::array<float, 16> decodeScalars(Block8 block) {
    const std::uint64_t bits = load(block);
    const std::uint32_t first = bits & 0xff, second = bits >> 8 & 0xff;
    const float a = static_cast<float>(first) / 255.0f, b = static_cast<float>(second) / 255.0f;
    std::array<float, 8> palette = {a, b};
    const int steps = first > second ? 7 : 5;
    for (int i = 1; i < steps; ++i)
        palette[static_cast<std::size_t>(i + 1)] =
            (static_cast<float>(steps - i) * a + static_cast<float>(i) * b) / static_cast<float>(steps);
    if (steps == 5) palette[7] = 1.0f;  // and palette[6] is 0
    std::array<float, 16> values;
    for (std::size_t texel = 0; texel < 16; ++texel) values[texel] = palette[bits >> (16 + 3 * texel) & 7];
    return values;
}

/// Decodes a signed block. With flipped sign bits, the bytes compare as unsigned, which selects the palette.
std::array<float, 16> decodeSignedScalars(Block8 block) {
    const std::uint64_t bits = load(block);
    const auto valueOf = [](std::uint64_t byte) {
        const int value = static_cast<int>(byte) - (byte >= 0x80 ? 0x100 : 0);
        return value == -0x80 ? -1.0f : static_cast<float>(value) / 127.0f;
    };
    const float a = valueOf(bits & 0xff), b = valueOf(bits >> 8 & 0xff);
    const bool isEight = ((bits & 0xff) ^ 0x80) > ((bits >> 8 & 0xff) ^ 0x80);
    std::array<float, 16> values;
    for (std::size_t texel = 0; texel < 16; ++texel) {
        const std::uint64_t index = bits >> (16 + 3 * texel) & 7;
        if (index < 2)
            values[texel] = index == 0 ? a : b;
        else if (!isEight && index >= 6)
            values[texel] = index == 6 ? -1.0f : 1.0f;
        else
            values[texel] = a + (b - a) * (static_cast<float>(index - 1) / (isEight ? 7.0f : 5.0f));
    }
    return values;
}

}  // namespace

void decodeBc1(Block8 block, Texels4x4 out) {
    decodeColours(block, true, 1.0f, out);
}

void decodeBc1Alpha(Block8 block, Texels4x4 out) {
    decodeColours(block, true, 0.0f, out);
}

void decodeBc3(Block16 block, Texels4x4 out) {
    decodeColours(block.last<8>(), false, 1.0f, out);
    const std::array<float, 16> alpha = decodeScalars(block.first<8>());
    for (std::size_t texel = 0; texel < 16; ++texel) out[texel].a = alpha[texel];
}

void decodeBc4(Block8 block, Texels4x4 out) {
    const std::array<float, 16> red = decodeScalars(block);
    for (std::size_t texel = 0; texel < 16; ++texel) out[texel] = {red[texel], 0.0f, 0.0f, 1.0f};
}

void decodeBc5(Block16 block, Texels4x4 out) {
    const std::array<float, 16> red = decodeScalars(block.first<8>()), green = decodeScalars(block.last<8>());
    for (std::size_t texel = 0; texel < 16; ++texel) out[texel] = {red[texel], green[texel], 0.0f, 1.0f};
}

void decodeBc4Snorm(Block8 block, Texels4x4 out) {
    const std::array<float, 16> red = decodeSignedScalars(block);
    for (std::size_t texel = 0; texel < 16; ++texel) out[texel] = {red[texel], 0.0f, 0.0f, 1.0f};
}

void decodeBc5Snorm(Block16 block, Texels4x4 out) {
    const std::array<float, 16> red = decodeSignedScalars(block.first<8>()), green = decodeSignedScalars(block.last<8>());
    for (std::size_t texel = 0; texel < 16; ++texel) out[texel] = {red[texel], green[texel], 0.0f, 1.0f};
}

}  // namespace lightcook::verify
