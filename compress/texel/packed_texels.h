// Formats without blocks: packed floats, halves, 16- and 8-bit integers.
#pragma once

#include <cstddef>
#include <glm/vec4.hpp>

#include "compress/encode_options.h"
#include "formats/pixel_format.h"

namespace lightcook::compress {

/// Writes one texel and returns its decoded value (missing channels 0, alpha 1).
/// texel   finite, already clamped to the range of the format
/// format  one of the formats without blocks
glm::vec4 encodeTexel(formats::PixelFormat format, const glm::vec4& texel, const EncodeOptions& options, std::byte* out);

/// Smallest and largest value of each channel of a format.
struct ChannelRange {
    glm::vec4 low, high;
};
ChannelRange rangeOf(formats::PixelFormat format);

}  // namespace lightcook::compress
