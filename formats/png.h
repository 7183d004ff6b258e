// PNG files in memory, with alpha.
#pragma once

#include <cstddef>
#include <glm/gtc/type_precision.hpp>
#include <span>
#include <string>
#include <vector>

#include "formats/environment.h"
#include "formats/error.h"
#include "formats/image.h"

namespace lightcook::formats {

/// Reads a PNG as it is stored: without colour conversion or multiplication by alpha. 8 and 16 bits become [0, 1].
/// subject  names it in errors
Result<PlainImage> decodePng(std::span<const std::byte> png, const std::string& subject);
/// Returns a PNG of 8 bits a channel. Colours are stored as they are, not multiplied by alpha.
Result<std::vector<std::byte>> encodePng(ImageView<const glm::u8vec4> texels);

}  // namespace lightcook::formats
