// PNG files, read and written in memory.
#pragma once

#include <cstddef>
#include <filesystem>
#include <glm/gtc/type_precision.hpp>
#include <span>
#include <string>
#include <vector>

#include "formats/error.h"
#include "formats/image.h"
#include "formats/plain_image.h"

namespace lightcook::formats {

/// Returns true if the bytes begin with the signature of a PNG.
bool isPng(std::span<const std::byte> bytes);
/// Returns true if a file does; false if it cannot be read.
bool isPngFile(const std::filesystem::path& file);
/// Reads a PNG as it is stored: without colour conversion or multiplication by alpha. Any number of bits becomes [0, 1].
/// subject  names it in errors
Result<PlainImage> decodePng(std::span<const std::byte> png, const Subject& subject);
/// Does the same with a file.
Result<PlainImage> readPng(const std::filesystem::path& file);

/// Returns a PNG of 8 bits a channel. Colours are stored as they are, not multiplied by alpha.
Result<std::vector<std::byte>> encodePng(ImageView<const glm::u8vec3> texels);
Result<std::vector<std::byte>> encodePng(ImageView<const glm::u8vec4> texels);

}  // namespace lightcook::formats
