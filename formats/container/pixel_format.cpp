#include "formats/pixel_format.h"

#include <array>
#include <cassert>

#include "formats/vocabulary.h"

namespace lightcook::formats {
namespace {

// VkFormat and DXGI_FORMAT numbers: the enumerations of the Vulkan specification (34.1) and of dxgiformat.h. BC1 is the RGB one (no alpha):
// its fourth palette entry in three-colour blocks is black either way. ASTC HDR is VK_FORMAT_ASTC_*_SFLOAT_BLOCK; DXGI never took ASTC, and
// has no 48-bit half format.
constexpr std::array kInfos = {
    //             format                     name             w  h bytes ch float  signed  vkFormat dxgi
    PixelFormatInfo{PixelFormat::Bc1, "bc1", 4, 4, 8, 3, false, false, 131, 71},
    PixelFormatInfo{PixelFormat::Bc3, "bc3", 4, 4, 16, 4, false, false, 137, 77},
    PixelFormatInfo{PixelFormat::Bc4, "bc4", 4, 4, 8, 1, false, false, 139, 80},
    PixelFormatInfo{PixelFormat::Bc4Snorm, "bc4-snorm", 4, 4, 8, 1, false, true, 140, 81},
    PixelFormatInfo{PixelFormat::Bc5, "bc5", 4, 4, 16, 2, false, false, 141, 83},
    PixelFormatInfo{PixelFormat::Bc5Snorm, "bc5-snorm", 4, 4, 16, 2, false, true, 142, 84},
    PixelFormatInfo{PixelFormat::Bc6hUf16, "bc6h-uf16", 4, 4, 16, 3, true, false, 143, 95},
    PixelFormatInfo{PixelFormat::Bc6hSf16, "bc6h-sf16", 4, 4, 16, 3, true, true, 144, 96},
    PixelFormatInfo{PixelFormat::Bc7, "bc7", 4, 4, 16, 4, false, false, 145, 98},
    PixelFormatInfo{PixelFormat::Astc4x4Hdr, "astc-4x4-hdr", 4, 4, 16, 4, true, false, 1000066000, 0},
    PixelFormatInfo{PixelFormat::Astc6x6Hdr, "astc-6x6-hdr", 6, 6, 16, 4, true, false, 1000066004, 0},
    PixelFormatInfo{PixelFormat::Astc8x8Hdr, "astc-8x8-hdr", 8, 8, 16, 4, true, false, 1000066007, 0},
    PixelFormatInfo{PixelFormat::Astc4x4Ldr, "astc-4x4-ldr", 4, 4, 16, 4, false, false, 157, 0},
    PixelFormatInfo{PixelFormat::Rgb9e5, "rgb9e5", 1, 1, 4, 3, true, false, 123, 67},
    PixelFormatInfo{PixelFormat::R11g11b10f, "r11g11b10f", 1, 1, 4, 3, true, false, 122, 26},
    PixelFormatInfo{PixelFormat::Rgba16f, "rgba16f", 1, 1, 8, 4, true, true, 97, 10},
    PixelFormatInfo{PixelFormat::Rgb16f, "rgb16f", 1, 1, 6, 3, true, true, 90, 0},
    PixelFormatInfo{PixelFormat::R16Unorm, "r16-unorm", 1, 1, 2, 1, false, false, 70, 56},
    PixelFormatInfo{PixelFormat::Rg16Unorm, "rg16-unorm", 1, 1, 4, 2, false, false, 77, 35},
    PixelFormatInfo{PixelFormat::Rgba16Unorm, "rgba16-unorm", 1, 1, 8, 4, false, false, 91, 11},
    PixelFormatInfo{PixelFormat::Rgba8Unorm, "rgba8-unorm", 1, 1, 4, 4, false, false, 37, 28},
    PixelFormatInfo{PixelFormat::Rgba8Srgb, "rgba8-srgb", 1, 1, 4, 4, false, false, 43, 29},
};

constexpr bool tableFollowsTheEnumeration() {
    for (std::size_t i = 0; i < kInfos.size(); ++i)
        if (static_cast<std::size_t>(kInfos[i].format) != i) return false;
    return kInfos.size() == static_cast<std::size_t>(PixelFormat::Rgba8Srgb) + 1;
}
static_assert(tableFollowsTheEnumeration());

}  // namespace

std::span<const PixelFormatInfo> allPixelFormats() {
    return kInfos;
}

const PixelFormatInfo& info(PixelFormat format) {
    assert(static_cast<std::size_t>(format) < kInfos.size());
    return kInfos[static_cast<std::size_t>(format)];
}

std::optional<PixelFormat> pixelFormatFromName(std::string_view name) {
    const PixelFormatInfo* row = findByName(allPixelFormats(), name);
    return row == nullptr ? std::nullopt : std::optional(row->format);
}

int blocksAcross(PixelFormat format, int width) {
    const int block = info(format).blockWidth;
    return width / block + (width % block != 0);
}

int blocksDown(PixelFormat format, int height) {
    const int block = info(format).blockHeight;
    return height / block + (height % block != 0);
}

std::size_t bytesPerBlockRow(PixelFormat format, int width) {
    return static_cast<std::size_t>(blocksAcross(format, width)) * static_cast<std::size_t>(info(format).bytesPerBlock);
}

std::size_t bytesPerImage(PixelFormat format, int width, int height) {
    return bytesPerBlockRow(format, width) * static_cast<std::size_t>(blocksDown(format, height));
}

}  // namespace lightcook::formats
