// PNG files in memory, with alpha.
#pragma once

#include <cstddef>
#include <glm/gtc/type_precision.hpp>
#include <vector>

#include "formats/error.h"
#include "formats/image.h"

namespace lightcook::formats {

/// Returns a PNG of 8 bits a channel. Colours are stored as they are, not multiplied by alpha.
Result<std::vector<std::byte>> encodePng(ImageView<const glm::u8vec4> texels);

}  // namespace lightcook::formats
