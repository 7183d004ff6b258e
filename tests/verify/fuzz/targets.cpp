#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "tests/fuzz/target.h"
#include "verify/texture/decode.h"
#include "verify/texture_unit.h"

namespace lightcook::verify {
namespace {

using formats::PixelFormat;

template <class Holds>
bool allChannels(const glm::vec4& texel, Holds holds) {
    return holds(texel.x) && holds(texel.y) && holds(texel.z) && holds(texel.w);
}

/// Returns true if a texel is what texture_unit.h says of the texels of any block of a format of floats.
/// isConstant   the block has the bits of one colour in ASTC
bool isDocumented(PixelFormat format, bool isConstant, const glm::vec4& texel) {
    if (allChannels(texel, [](float value) { return std::isfinite(value); })) return true;
    switch (format) {
        case PixelFormat::Rgba16f:
        case PixelFormat::Rgb16f:
        case PixelFormat::R11g11b10f:
            return true;
        case PixelFormat::Bc6hSf16:
            return allChannels(texel, [](float value) { return std::isfinite(value) || value == -HUGE_VALF; });
        case PixelFormat::Astc4x4Hdr:
        case PixelFormat::Astc6x6Hdr:
        case PixelFormat::Astc8x8Hdr:
            return isConstant || allChannels(texel, [](float value) { return std::isnan(value); });
        default:
            return false;
    }
}

void checkTexels(const formats::PixelFormatInfo& info, bool isConstant, std::span<const glm::vec4> texels) {
    const float low = info.isSigned ? -1.0f : 0.0f;
    for (const glm::vec4& texel : texels) {
        if (info.isFloat)
            fuzz::require(isDocumented(info.format, isConstant, texel), "a texel is finite, or what texture_unit.h says");
        else
            fuzz::require(allChannels(texel, [&](float value) { return value >= low && value <= 1; }), "a texel of integers is in range");
    }
}

/// Decodes the bytes as a block of every format.
void decodeAsEach(fuzz::Bytes bytes) {
    std::array<std::byte, 16> block{};
    std::copy_n(bytes.begin(), std::min(bytes.size(), block.size()), block.begin());
    const bool isConstant = BlockBits(block).take(9) == 0x1fc;
    std::array<glm::vec4, 144> texels;
    for (const formats::PixelFormatInfo& info : formats::allPixelFormats()) {
        const auto out = std::span(texels).first(static_cast<std::size_t>(info.blockWidth * info.blockHeight));
        std::ranges::fill(out, glm::vec4(NAN));
        decodeBlock(info.format, std::span(block).first(static_cast<std::size_t>(info.bytesPerBlock)), out);
        checkTexels(info, isConstant, out);
    }
    const auto out = std::span(texels).first<16>();
    decodeBc1Alpha(std::span(block).first<8>(), out);
    checkTexels(formats::info(PixelFormat::Bc1), false, out);
    // Extents of blocks that no format of ours has, as far as the format goes.
    for (const auto& [width, height] : {std::array{5, 4}, std::array{10, 6}, std::array{12, 12}})
        for (const bool isHdr : {false, true})
            decodeAstc(block, width, height, isHdr, std::span(texels).first(static_cast<std::size_t>(width * height)));
}

constexpr std::array kFuzzTargets = {fuzz::Target{"block", decodeAsEach}};

}  // namespace
}  // namespace lightcook::verify

std::span<const lightcook::fuzz::Target> lightcook::fuzz::targets() {
    return verify::kFuzzTargets;
}
