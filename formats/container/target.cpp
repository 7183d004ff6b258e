#include "formats/target.h"

#include <array>

#include "formats/vocabulary.h"

namespace lightcook::formats {
namespace {

constexpr std::array kTargets = {
    TargetInfo{.id = Target::Bc,
               .name = "bc",
               .caption = "desktop and consoles: BC6H, BC7, BC3",
               .hdr = PixelFormat::Bc6hUf16,
               .hdrFine = PixelFormat::Rgb9e5,
               .ldr = PixelFormat::Bc7,
               .ldrRgb = PixelFormat::Bc1,
               .ldrAlpha = PixelFormat::Bc3,
               .table = PixelFormat::Rgba16Unorm,
               .deviceNeed = "textureCompressionBC (Vulkan), feature level 11_0 (Direct3D)"},
    TargetInfo{.id = Target::Astc,
               .name = "astc",
               .caption = "mobile: ASTC 4x4, HDR and LDR",
               .hdr = PixelFormat::Astc4x4Hdr,
               .hdrFine = PixelFormat::Rgb9e5,
               .ldr = PixelFormat::Astc4x4Ldr,
               .ldrRgb = PixelFormat::Astc4x4Ldr,
               .ldrAlpha = PixelFormat::Astc4x4Ldr,
               .table = PixelFormat::Rgba16f,  // 16-bit UNORM is an extension of OpenGL ES and optional in Vulkan
               .deviceNeed = "textureCompressionASTC_LDR and VK_EXT_texture_compression_astc_hdr (Vulkan)"},
    TargetInfo{.id = Target::Float,
               .name = "float",
               .caption = "16-bit floats and integers without blocks, for comparison",
               .hdr = PixelFormat::Rgba16f,
               .hdrFine = PixelFormat::Rgba16f,
               .ldr = PixelFormat::Rgba16Unorm,
               .ldrRgb = PixelFormat::Rgba16Unorm,
               .ldrAlpha = PixelFormat::Rgba16Unorm,
               .table = PixelFormat::Rgba16Unorm,
               .deviceNeed = "filtering of VK_FORMAT_R16G16B16A16_UNORM and _SFLOAT (Vulkan)"},
};
static_assert(isCompleteTable(kTargets, Target::Float));

}  // namespace

std::span<const TargetInfo> allTargets() {
    return kTargets;
}

const TargetInfo& info(Target target) {
    return kTargets[static_cast<std::size_t>(target)];
}

std::optional<Target> targetFromName(std::string_view name) {
    const TargetInfo* row = findByName(allTargets(), name);
    return row == nullptr ? std::nullopt : std::optional(row->id);
}

}  // namespace lightcook::formats
