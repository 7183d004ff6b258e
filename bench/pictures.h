// What encoders are measured on: light as formats of half precision hold it, and which of its texels count.
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

/// Values are halfs, alpha 1. Negative ones only in SH bands.
struct Picture {
    std::string name;
    PictureKind kind = PictureKind::Generated;
    formats::Image<glm::vec4> texels;
    formats::Image<float> significance;  ///< 1 where a texel counts, else 0
};

/// The panoramas and light maps (coefficient 0) of a copy of ../shared/data, with a band of order 1 and one of order 2 of each map. Files
/// that cannot be read are named on standard error.
std::vector<Picture> sharedPictures(const std::filesystem::path& data);

/// What the repository carries or makes itself, size x size texels each: parts of examples/cornell and patterns made by formula.
std::vector<Picture> ownPictures(const std::filesystem::path& sources, int size);

/// Whether a picture is of use to a format: SH bands only to formats with a sign.
bool suits(const Picture& picture, formats::PixelFormat format);

/// The texels as the format is given them. Float formats: as they are. Others: v = (x / (1 + x))^(1/2.2) for colour, and alpha as data made
/// of it, 1 - (r + 2 g + b) / 4.
formats::Image<glm::vec4> texelsFor(const Picture& picture, formats::PixelFormat format);

}  // namespace lightcook::bench
