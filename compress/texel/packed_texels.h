// Formats whose texels stand alone: packed floats, halves, 16- and 8-bit integers.
#pragma once

#include <cstddef>
#include <glm/vec4.hpp>

#include "compress/encode.h"

namespace lightcook::compress {

/// Writes one texel and returns what it decodes to (missing channels 0, alpha 1).
/// texel   finite, already clamped to the format's range
/// format  one of the formats without blocks
glm::vec4 encodeTexel(formats::PixelFormat format, const glm::vec4& texel, const EncodeOptions& options, std::byte* out);

/// Least and largest value that the format holds, by channel.
struct ChannelRange {
    glm::vec4 low, high;
};
ChannelRange rangeOf(formats::PixelFormat format);

}  // namespace lightcook::compress
