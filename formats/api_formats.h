// Numbers of the pixel formats in the graphics APIs, for loaders that create textures from a manifest.
#pragma once

#include <cstdint>
#include <optional>

#include "formats/pixel_format.h"

namespace lightcook::formats {

/// A format's number in each API. Absent: the API has no such format.
struct ApiFormats {
    std::uint32_t vulkan = 0;            ///< VkFormat
    std::optional<std::uint32_t> dxgi;   ///< DXGI_FORMAT
    std::uint32_t gl = 0;                ///< sized internal format of OpenGL and OpenGL ES
    std::optional<std::uint32_t> metal;  ///< MTLPixelFormat
    bool operator==(const ApiFormats&) const = default;
};
ApiFormats apiFormats(PixelFormat format);

}  // namespace lightcook::formats
