// ASTC through libastcenc.
#pragma once

#include "compress/encode.h"

namespace lightcook::compress {

/// Encodes whole images or bands of ASTC blocks; arguments as encodeRows, texels already in the format's range.
/// libastcenc 4.2 knows no weight of a single texel: texels without significance take the value of the nearest of their block that has
/// some, so that they cost next to nothing; other differences of significance inside a block are not passed on.
void encodeAstc(formats::PixelFormat format, formats::ImageView<const glm::vec4> texels, formats::ImageView<const float> significance,
                const EncodeOptions& options, std::span<std::byte> out, formats::ImageView<glm::vec4> decoded);

}  // namespace lightcook::compress
