// Images as they are stored, in four channels: pictures, textures, light maps of one image.
#pragma once

#include <array>
#include <filesystem>
#include <glm/vec4.hpp>
#include <optional>
#include <string>
#include <vector>

#include "formats/error.h"
#include "formats/image.h"

namespace lightcook::formats {

/// The projection that the attribute `envmap` of an OpenEXR file states. Directions are those of OpenEXR (ImfEnvmap.h).
enum class ExrEnvironment { LatLong, Cube };

/// CIE x, y of red, green, blue and white.
using StatedChromaticities = std::array<float, 8>;

/// An image as RGBA float, without colour conversion or multiplication by alpha. 8 and 16 bits become [0, 1], grey is in R, G and B, and of
/// channels that are missing alpha is 1 and the others 0.
/// channelCount  of the channels that were read, at most 4
/// ignored       names of the channels of an OpenEXR file that were not
struct PlainImage {
    Image<glm::vec4> texels;
    int channelCount = 0;
    bool hasAlpha = false;
    std::vector<std::string> ignored = {};
    std::optional<StatedChromaticities> chromaticities = {};  ///< of OpenEXR and Radiance files that state them
    std::optional<ExrEnvironment> environment = {};
};

/// Returns true for PNG, JPEG, TGA and BMP: files of integers, whose colours are usually under the sRGB curve.
bool isPictureFile(const std::filesystem::path& file);
/// Reads any image that OpenImageIO supports. Loads that library for images that are neither PNG, nor RGBE (radianceFactors() are divided
/// out), nor OpenEXR, nor a BMP of 32 bits. Channels of OpenEXR are found by name: see exr_colours.h.
Result<PlainImage> readImage(const std::filesystem::path& file);
/// Brings an image whose file states `environment` to the directions and texel centres of environment.h, and forgets the statement. Fails
/// for another shape than that of the environment. subject  names the image in errors
Result<void> resampleEnvironment(PlainImage& image, const Subject& subject);

/// The names of the channels of a flat OpenEXR file and its extent, without texels.
struct ExrContent {
    int width = 0, height = 0;
    std::vector<std::string> channels;
};
Result<ExrContent> exrContent(const std::filesystem::path& file);
/// Writes a float EXR with the first channelCount (1 .. 4) of R, G, B, A. The file appears when it is complete.
Result<void> writeExr(const std::filesystem::path& file, ImageView<const glm::vec4> texels, int channelCount);

}  // namespace lightcook::formats
