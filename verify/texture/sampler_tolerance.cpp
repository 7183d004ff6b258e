#include "verify/sampler_tolerance.h"

#include <cassert>
#include <cstdint>

namespace lightcook::verify {
namespace {

/// Tolerance of interpolated texels relative to the difference of a block's endpoints, in every channel of BC1 to BC5.
constexpr float kSpanShare = 0.03f;

bool hasGreen(formats::PixelFormat format) {
    return format == formats::PixelFormat::Bc5 || format == formats::PixelFormat::Bc5Snorm;
}

/// Returns the difference of the endpoints of a BC1 colour block.
glm::vec4 colourSpan(std::span<const std::byte> block) {
    const auto endAt = [&](std::size_t byte) {
        const std::uint32_t bits = std::to_integer<std::uint32_t>(block[byte]) | std::to_integer<std::uint32_t>(block[byte + 1]) << 8;
        return glm::vec4(static_cast<float>(bits >> 11) / 31, static_cast<float>(bits >> 5 & 63) / 63, static_cast<float>(bits & 31) / 31,
                         0);
    };
    return glm::abs(endAt(0) - endAt(2));
}
/// Returns the difference of a BC4 block's two bytes; those of a signed block are 127ths.
float scalarSpan(std::span<const std::byte> block, bool isSigned) {
    const auto endAt = [&](std::size_t byte) {
        const int value = std::to_integer<int>(block[byte]);
        return isSigned ? static_cast<float>(value < 0x80 ? value : value - 0x100) / 127 : static_cast<float>(value) / 255;
    };
    return glm::abs(endAt(0) - endAt(1));
}
glm::vec4 spanOf(formats::PixelFormat format, std::span<const std::byte> block) {
    const bool isSigned = formats::info(format).isSigned;
    if (format == formats::PixelFormat::Bc1) return colourSpan(block);
    glm::vec4 span(0);
    if (format == formats::PixelFormat::Bc3) {
        span = colourSpan(block.subspan(8));
        span.a = scalarSpan(block, false);
        return span;
    }
    span.r = scalarSpan(block, isSigned);
    if (hasGreen(format)) span.g = scalarSpan(block.subspan(8), isSigned);
    return span;
}

}  // namespace

FormatTolerance toleranceOf(formats::PixelFormat format) {
    using formats::PixelFormat;
    constexpr float kCode8 = 1.0f / 255, kCode16 = 1.0f / 65535, kHalfStep = 0x1p-10f;
    constexpr FormatTolerance kEight{2 * kCode8, 0, glm::vec4(0), glm::vec4(0)}, kSixteen{2 * kCode16, 0, glm::vec4(0), glm::vec4(0)},
        kHalf{0, kHalfStep, glm::vec4(0), glm::vec4(0)};
    FormatTolerance blocks = kEight;
    switch (format) {
        case PixelFormat::Bc1:
            blocks.decoded = {2 * kCode8, 2 * kCode8, 2 * kCode8, 0};
            blocks.perSpan = {kSpanShare, kSpanShare, kSpanShare, 0};
            return blocks;
        case PixelFormat::Bc3:
            blocks.decoded = glm::vec4(2 * kCode8);
            blocks.perSpan = glm::vec4(kSpanShare);
            return blocks;
        case PixelFormat::Bc4Snorm:
        case PixelFormat::Bc5Snorm:
            blocks.absolute = 4 * kCode8;  // steps of signed formats are twice as wide
            [[fallthrough]];
        case PixelFormat::Bc4:
        case PixelFormat::Bc5:
            blocks.decoded = {blocks.absolute, hasGreen(format) ? blocks.absolute : 0, 0, 0};
            blocks.perSpan = {kSpanShare, hasGreen(format) ? kSpanShare : 0, 0, 0};
            return blocks;
        case PixelFormat::Astc4x4Ldr:
            blocks.decoded = glm::vec4(kCode8);
            return blocks;
        case PixelFormat::Bc7:
        case PixelFormat::Rgba8Unorm:
        case PixelFormat::Rgba8Srgb:
            return kEight;
        case PixelFormat::R16Unorm:
        case PixelFormat::Rg16Unorm:
        case PixelFormat::Rgba16Unorm:
            return kSixteen;
        default:  // BC6H, ASTC's HDR profile, halves, and packed floats, which are filtered as halves at least
            return kHalf;
    }
}

formats::Image<glm::vec4> blockSpans(formats::PixelFormat format, std::span<const std::byte> blocks, int width) {
    if (!toleranceOf(format).hasSpans()) return {};
    const std::size_t bytes = static_cast<std::size_t>(formats::info(format).bytesPerBlock);
    const int across = (width + 3) / 4;
    assert(blocks.size() % (bytes * static_cast<std::size_t>(across)) == 0);
    formats::Image<glm::vec4> spans(across, static_cast<int>(blocks.size() / bytes) / across);
    std::size_t at = 0;
    for (glm::vec4& span : spans.texels()) {
        span = spanOf(format, blocks.subspan(at, bytes));
        at += bytes;
    }
    return spans;
}

}  // namespace lightcook::verify
