#include "verify/light_map_freedom.h"

#include <cassert>
#include <cstdint>

namespace verify {

FormatFreedom freedomOf(formats::PixelFormat format) {
    using formats::PixelFormat;
    constexpr float kCode8 = 1.0f / 255, kCode16 = 1.0f / 65535, kHalfStep = 0x1p-10f;
    constexpr FormatFreedom kEight{2 * kCode8, 0, glm::vec4(0), glm::vec4(0)}, kSixteen{2 * kCode16, 0, glm::vec4(0), glm::vec4(0)},
        kHalf{0, kHalfStep, glm::vec4(0), glm::vec4(0)};
    FormatFreedom blocks = kEight;
    switch (format) {
        case PixelFormat::Bc1:
            blocks.decoded = {2 * kCode8, 2 * kCode8, 2 * kCode8, 0};
            blocks.perSpan = {0.03f, 0.03f, 0.03f, 0};
            return blocks;
        case PixelFormat::Bc3:
            blocks.decoded = glm::vec4(2 * kCode8);
            blocks.perSpan = {0.03f, 0.03f, 0.03f, 0};
            return blocks;
        case PixelFormat::Bc4:
        case PixelFormat::Bc5:
            blocks.decoded = glm::vec4(2 * kCode8);
            return blocks;
        case PixelFormat::Bc4Snorm:
        case PixelFormat::Bc5Snorm:
            blocks.absolute = 4 * kCode8;  // steps are twice as wide
            blocks.decoded = glm::vec4(4 * kCode8);
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
    if (!freedomOf(format).hasSpans()) return {};
    const std::size_t bytes = static_cast<std::size_t>(formats::info(format).bytesPerBlock), colours = bytes - 8;
    const int across = (width + 3) / 4;
    assert(blocks.size() % (bytes * static_cast<std::size_t>(across)) == 0);
    formats::Image<glm::vec4> spans(across, static_cast<int>(blocks.size() / bytes) / across);
    std::size_t at = colours;
    for (glm::vec4& span : spans.texels()) {
        const auto endAt = [&](std::size_t byte) {
            const std::uint32_t bits = std::to_integer<std::uint32_t>(blocks[byte]) | std::to_integer<std::uint32_t>(blocks[byte + 1]) << 8;
            return glm::vec4(static_cast<float>(bits >> 11) / 31, static_cast<float>(bits >> 5 & 63) / 63,
                             static_cast<float>(bits & 31) / 31, 0);
        };
        span = glm::abs(endAt(at) - endAt(at + 2));
        at += bytes;
    }
    return spans;
}

}  // namespace verify
