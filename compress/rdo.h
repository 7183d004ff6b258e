// Rate-distortion optimisation of blocks for files that are compressed once more: where a block, or a half of it, can repeat what stands a
// little before it at a small price, it does, and Zstandard stores a match in place of literals.
#pragma once

#include <cstddef>
#include <span>

#include "compress/encode.h"

namespace lightcook::compress {

/// Whether reduceRow knows the format: BC1, BC3, BC4, BC5, BC6H and BC7.
bool canReduce(formats::PixelFormat format);

/// Replaces blocks of one row, or byte ranges of them, by copies of others to their left; where a BC7 block takes over everything before
/// the indices, it gets the best indices for that. texels        what the row shows, 1 .. 4 high, as given to the encoder significance  as
/// given to the encoder; a view without texels counts every texel as 1 options       rdo: the root of the row's weighted squared error, in
/// the encoder's own metric, grows by at most this share. Never more:
///               a row without error changes only where that costs nothing
/// row           encoded blocks of these texels
/// The result depends on the row alone, so that cuts between rows of blocks do not matter.
void reduceRow(formats::PixelFormat format, formats::ImageView<const glm::vec4> texels, formats::ImageView<const float> significance,
               const EncodeOptions& options, std::span<std::byte> row);

}  // namespace lightcook::compress
