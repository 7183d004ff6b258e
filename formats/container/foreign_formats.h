// Names of pixel formats by the numbers that files store, also of formats that lightcook does not read: errors name what was found.
// Sources: the enumeration VkFormat of the Vulkan specification, DXGI_FORMAT of dxgiformat.h, D3DFORMAT of d3d9types.h, and "Programming
// Guide for DDS" (Microsoft).
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "formats/pixel_format.h"

namespace lightcook::formats {

/// Returns "VK_FORMAT_BC2_UNORM_BLOCK (135)"; of a number without a name the number.
std::string vkFormatName(std::uint32_t vkFormat);
/// Returns "BC2_UNORM (74)"; of a number without a name the number.
std::string dxgiFormatName(std::uint32_t dxgiFormat);

/// A format that DDS files of before Direct3D 10 name by four letters, or by a number of D3DFORMAT.
struct LegacyDdsFormat {
    std::optional<PixelFormat> format;  ///< empty: lightcook does not read it
    std::string name;                   ///< "DXT3 (BC2)"
    std::string remedy;                 ///< what to do if it is not read
};
LegacyDdsFormat legacyDdsFormat(std::uint32_t fourCc);

}  // namespace lightcook::formats
