// Images as they are stored, in four channels: pictures, textures, light maps of one image.
#pragma once

#include <filesystem>
#include <glm/vec4.hpp>

#include "formats/error.h"
#include "formats/image.h"

namespace lightcook::formats {

/// An image as RGBA float, without colour conversion or multiplication by alpha. 8 and 16 bits become [0, 1], grey is in R, G and B, and of
/// channels that are missing alpha is 1 and the others 0.
/// channelCount  of the file; channels after the fourth are dropped
struct PlainImage {
    Image<glm::vec4> texels;
    int channelCount = 0;
};

/// Returns true for PNG, JPEG, TGA and BMP: files of integers, whose colours are usually under the sRGB curve.
bool isPictureFile(const std::filesystem::path& file);
/// Reads any image that OpenImageIO supports. Loads that library for images that are neither PNG, nor RGBE (radianceFactors() are divided
/// out), nor a flat EXR whose channels are R, RG or RGB, with or without A.
Result<PlainImage> readImage(const std::filesystem::path& file);
/// Writes a float EXR with the first channelCount (1 .. 4) of R, G, B, A. The file appears when it is complete.
Result<void> writeExr(const std::filesystem::path& file, ImageView<const glm::vec4> texels, int channelCount);

}  // namespace lightcook::formats
