// ASTC through libastcenc.
#pragma once

#include <cstddef>
#include <glm/vec4.hpp>
#include <span>

#include "compress/encode_options.h"
#include "formats/image.h"
#include "formats/pixel_format.h"

namespace lightcook::compress {

/// Encodes whole images or strips of ASTC blocks. Arguments as for encodeRows; texels are already in the range of the format.
/// libastcenc 4.2 has no weight per texel. Texels of significance 0 take the value of the nearest significant texel of their block, so that
/// they cost almost nothing; other differences of significance inside a block are ignored.
void encodeAstc(formats::PixelFormat format, formats::ImageView<const glm::vec4> texels, formats::ImageView<const float> significance,
                const EncodeOptions& options, std::span<std::byte> out, formats::ImageView<glm::vec4> decoded);

}  // namespace lightcook::compress
