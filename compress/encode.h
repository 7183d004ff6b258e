// Encodes texels into GPU blocks: one call for every pixel format. Pure: no thread, no file; callers spread rows of blocks over threads.
// The same texels give the same bytes no matter how the rows are cut, provided that cuts fall between blocks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec4.hpp>
#include <span>

#include "compress/encode_options.h"
#include "formats/image.h"
#include "formats/pixel_format.h"

namespace lightcook::compress {

/// Counts the channel values that were clamped into the range of the format. Texels of significance 0 are not counted.
struct EncodeReport {
    std::int64_t clampedHigh = 0;      ///< above the format's largest value, or below its smallest in a signed format
    std::int64_t clampedNegative = 0;  ///< below zero in an unsigned format
    void add(const EncodeReport& other) {
        clampedHigh += other.clampedHigh;
        clampedNegative += other.clampedNegative;
    }
};

/// Returns true for the formats to which EncodeOptions::rdo applies: BC1, BC3, BC4, BC5, BC6H and BC7.
bool supportsRdo(formats::PixelFormat format);

/// Encodes rows of blocks.
/// texels        finite; scene-linear for float formats, in [0, 1] for unorm and in [-1, 1] for snorm formats. Channels that the format
///               lacks are ignored. Width and height need not be multiples of the block size: missing texels repeat the edge and have
///               weight 0
/// significance  weight >= 0 of each texel, same extent; an empty view weights every texel by 1. A block whose texels all have weight 0
///               is encoded as if they all had weight 1
/// out           blocksDown * bytesPerBlockRow bytes
/// decoded       receives the decoded blocks, same extent; an empty view skips decoding
EncodeReport encodeRows(formats::PixelFormat format, formats::ImageView<const glm::vec4> texels,
                        formats::ImageView<const float> significance, const EncodeOptions& options, std::span<std::byte> out,
                        formats::ImageView<glm::vec4> decoded);

}  // namespace lightcook::compress
