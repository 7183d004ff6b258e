// Test pictures for encoders: light in half precision, and the significance of the texels.
#pragma once

#include <filesystem>
#include <glm/vec4.hpp>
#include <string>
#include <vector>

#include "formats/image.h"
#include "formats/pixel_format.h"

namespace lightcook::bench {

enum class PictureKind { Panorama, LightMap, Generated, ShBand };
std::string_view nameOf(PictureKind kind);

/// Values are halves, alpha 1. Only SH bands have negative ones.
struct Picture {
    std::string name;
    PictureKind kind = PictureKind::Generated;
    formats::Image<glm::vec4> texels;
    formats::Image<float> significance;  ///< 1 where a texel counts, else 0
};

/// Returns the panoramas and light maps (coefficient 0, and one coefficient each of bands 1 and 2) of the shared data. Prints the names of
/// unreadable files to standard error.
std::vector<Picture> sharedPictures(const std::filesystem::path& data);

/// Returns the pictures that need no shared data, size x size texels each: parts of examples/cornell and patterns made by formula.
std::vector<Picture> ownPictures(const std::filesystem::path& sources, int size);

/// Returns true if a format can hold a picture: SH bands need a signed format.
bool suits(const Picture& picture, formats::PixelFormat format);

/// Returns the texels as a format encodes them. Float formats: unchanged. Others: v = sign(x) (|x| / (1 + |x|))^(1/2.2) for colour, and an
/// alpha that varies with it, 1 - (r + 2 g + b) / 4.
formats::Image<glm::vec4> texelsFor(const Picture& picture, formats::PixelFormat format);

}  // namespace lightcook::bench
