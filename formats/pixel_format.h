// The GPU texel formats that lightcook writes, with block size, channels and the numbers of Vulkan and DXGI.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace lightcook::formats {

enum class PixelFormat : std::uint8_t {
    Bc1,
    Bc3,
    Bc4,
    Bc4Snorm,
    Bc5,
    Bc5Snorm,
    Bc6hUf16,
    Bc6hSf16,
    Bc7,
    Astc4x4Hdr,
    Astc6x6Hdr,
    Astc8x8Hdr,
    Astc4x4Ldr,
    Rgb9e5,
    R11g11b10f,
    Rgba16f,
    Rgb16f,
    R16Unorm,
    Rg16Unorm,
    Rgba16Unorm,
    Rgba8Unorm,
    Rgba8Srgb,
};

struct PixelFormatInfo {
    PixelFormat format;
    std::string_view name;     ///< as in `encode --format`: "bc6h-uf16"
    int blockWidth;            ///< [texels]; 1 for formats that are not made of blocks
    int blockHeight;           ///< [texels]
    int bytesPerBlock;         ///< a texel of formats without blocks
    int channelCount;          ///< that a decoder gives back: BC1 as RGB 3, BC3 4, BC4 1, BC5 2, BC6H 3, BC7 4, ASTC 4
    bool isFloat;              ///< decodes to floating point rather than to [0, 1], or [-1, 1]
    bool isSigned;             ///< can hold negative values
    std::uint32_t vkFormat;    ///< Vulkan's VkFormat, as KTX2 stores it
    std::uint32_t dxgiFormat;  ///< DXGI_FORMAT, as DDS stores it; 0 where DXGI has none
};

/// Every format, in the order of the enumeration.
std::span<const PixelFormatInfo> allPixelFormats();
const PixelFormatInfo& info(PixelFormat format);
std::optional<PixelFormat> pixelFormatFromName(std::string_view name);

/// Extent of one image of a texture in blocks, and its size [bytes]. A partial block counts as a whole one.
int blocksAcross(PixelFormat format, int width);
int blocksDown(PixelFormat format, int height);
std::size_t bytesPerBlockRow(PixelFormat format, int width);
std::size_t bytesPerImage(PixelFormat format, int width, int height);

}  // namespace lightcook::formats
