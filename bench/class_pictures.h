// Pictures for comparisons of encoders, in classes by content: an encoder that is good at photographs may be bad at normals.
#pragma once

#include <cstddef>
#include <filesystem>
#include <glm/vec4.hpp>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/image.h"
#include "formats/pixel_format.h"

namespace lightcook::bench {

enum class PictureClass { Photographs, Panoramas, LightMaps, ShRatios, Normals, Directions };

/// The range and the meaning of the texels of a class, which decide the formats that can hold them.
enum class PictureContent {
    Colour,  ///< [0, 1], opaque: formats of unsigned integers
    Light,   ///< linear light in halves: float formats
    Vectors  ///< [-1, 1]: signed float formats, and integer formats, where unsigned ones hold (v + 1) / 2
};

struct PictureClassInfo {
    std::string_view name;
    PictureClass pictureClass;
    PictureContent content;
};
std::span<const PictureClassInfo> allPictureClasses();
const PictureClassInfo& info(PictureClass pictureClass);

struct ClassPicture {
    std::string name;
    PictureClass pictureClass = PictureClass::Photographs;
    formats::Image<glm::vec4> texels;
    formats::Image<float> significance;  ///< 1 where the error counts, 0 outside charts: such texels repeat the nearest one that counts
};

/// Side of the tiles that pictures are composed of [texels]: whole blocks of every format, since 4, 6 and 8 divide it.
inline constexpr int kPictureTile = 48;

/// Returns pictures of every class that need no shared data: parts of examples/cornell and patterns made by formula.
/// side  [texels], a multiple of kPictureTile
std::vector<ClassPicture> ownClassPictures(const std::filesystem::path& sources, int side);

/// Returns pictures of the panoramas and light maps of the shared data, and the normals made by formula. Large pictures are reduced to
/// evenly spread tiles. Empty without shared data.
std::vector<ClassPicture> sharedClassPictures(const std::filesystem::path& data, const std::filesystem::path& sources, int side);

/// Returns the pictures of a folder (PNG, JPEG, TGA, BMP) as photographs, opaque, by name; large ones are reduced to evenly spread tiles.
/// Throws std::runtime_error for a folder without pictures, and for a picture that cannot be read.
std::vector<ClassPicture> photographsOf(const std::filesystem::path& folder, int side);

/// Returns true if a format can hold the content of a class.
bool suits(PictureContent content, formats::PixelFormat format);

/// Returns the texels as a format encodes them. Integer formats: rounded to bytes, so that encoders that read bytes lose nothing.
formats::Image<glm::vec4> texelsFor(const ClassPicture& picture, formats::PixelFormat format);

}  // namespace lightcook::bench
