// Sources: the OpenGL registry (gl.xml; EXT_texture_compression_s3tc, ARB_texture_compression_rgtc and _bptc,
// KHR_texture_compression_astc_ldr), and Metal's header MTLPixelFormat.h. OpenGL has one number for ASTC LDR and HDR.
#include "formats/api_formats.h"

#include <array>

namespace lightcook::formats {
namespace {

struct Row {
    PixelFormat format;
    std::uint32_t gl, metal;  ///< metal 0: none
};
constexpr std::array kRows = {
    Row{PixelFormat::Bc1, 0x83F0, 130},        Row{PixelFormat::Bc3, 0x83F3, 134},         Row{PixelFormat::Bc4, 0x8DBB, 140},
    Row{PixelFormat::Bc4Snorm, 0x8DBC, 141},   Row{PixelFormat::Bc5, 0x8DBD, 142},         Row{PixelFormat::Bc5Snorm, 0x8DBE, 143},
    Row{PixelFormat::Bc6hUf16, 0x8E8F, 151},   Row{PixelFormat::Bc6hSf16, 0x8E8E, 150},    Row{PixelFormat::Bc7, 0x8E8C, 152},
    Row{PixelFormat::Astc4x4Hdr, 0x93B0, 222}, Row{PixelFormat::Astc6x6Hdr, 0x93B4, 226},  Row{PixelFormat::Astc8x8Hdr, 0x93B7, 230},
    Row{PixelFormat::Astc4x4Ldr, 0x93B0, 204}, Row{PixelFormat::Rgb9e5, 0x8C3D, 93},       Row{PixelFormat::R11g11b10f, 0x8C3A, 92},
    Row{PixelFormat::Rgba16f, 0x881A, 115},    Row{PixelFormat::Rgb16f, 0x881B, 0},        Row{PixelFormat::R16Unorm, 0x822A, 20},
    Row{PixelFormat::Rg16Unorm, 0x822C, 60},   Row{PixelFormat::Rgba16Unorm, 0x805B, 110}, Row{PixelFormat::Rgba8Unorm, 0x8058, 70},
    Row{PixelFormat::Rgba8Srgb, 0x8C43, 71},
};

constexpr bool rowsFollowTheEnumeration() {
    for (std::size_t i = 0; i < kRows.size(); ++i)
        if (static_cast<std::size_t>(kRows[i].format) != i) return false;
    return kRows.size() == static_cast<std::size_t>(PixelFormat::Rgba8Srgb) + 1;
}
static_assert(rowsFollowTheEnumeration());

}  // namespace

ApiFormats apiFormats(PixelFormat format) {
    const auto present = [](std::uint32_t number) { return number != 0 ? std::optional(number) : std::nullopt; };
    const Row& row = kRows.at(static_cast<std::size_t>(format));
    return {info(format).vkFormat, present(info(format).dxgiFormat), row.gl, present(row.metal)};
}

}  // namespace lightcook::formats
