// Rate-distortion optimization of encoded blocks, for files that are compressed once more (Zstandard). A block, or a part of it, is
// replaced by a copy of a block to its left where that costs little error, so that the compressor stores a match in place of literals.
#pragma once

#include <cstddef>
#include <glm/vec4.hpp>
#include <span>

#include "compress/encode_options.h"
#include "formats/image.h"
#include "formats/pixel_format.h"

namespace lightcook::compress {

/// Replaces blocks of one row, or byte ranges of them, by copies of blocks to their left. A BC6H or BC7 block may copy everything before
/// its indices (the head); it then gets the best indices for that head.
/// texels        the texels of the row, 1 .. 4 high, as given to the encoder
/// significance  as given to the encoder; an empty view weights every texel by 1
/// options       rdo: the RMS error of the row, weighted and in the encoder's own metric, grows by at most this share. If that metric is
///               not linear, so does the RMS error of the values, weighted by the roots of the weights; if it is linear, no texel of
///               padding (weight of 1/1024 to 1/2 of the heaviest) adds more than 16 times the RMS error of the row to its own. A row
///               without error changes only where that costs nothing
/// row           the encoded blocks of these texels; supportsRdo(format) is true
/// The result depends on the row alone, so an image may be cut between any two rows of blocks.
void reduceRow(formats::PixelFormat format, formats::ImageView<const glm::vec4> texels, formats::ImageView<const float> significance,
               const EncodeOptions& options, std::span<std::byte> row);

}  // namespace lightcook::compress
