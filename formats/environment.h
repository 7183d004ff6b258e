// HDR environments (equirectangular panoramas; six cube faces as strips, crosses or files) and 1-D radially symmetric gradients, from EXR
// or Radiance HDR.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/gtc/type_precision.hpp>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "formats/color.h"
#include "formats/error.h"
#include "formats/image.h"
#include "lighting/sh.h"

namespace lightcook::formats {

/// Incident radiance from every direction, scene-linear working colour, finite and non-negative.
struct Environment {
    enum class Projection { Equirectangular, CubeStrip };
    Projection projection = Projection::Equirectangular;
    Image<glm::vec3> texels;  ///< width = 2 height; or a vertical strip: height = 6 width, faces +X -X +Y -Y +Z -Z from top to bottom
};

struct EnvironmentOptions {
    ColorSpaces colors;
    /// Texels that hold NaN, infinity or a negative value become zero and are counted, instead of refused; channels that the conversion to
    /// the working space makes negative become zero, and their texels are counted too.
    bool repair = false;
};
struct LoadedEnvironment {
    Environment environment;
    std::int64_t repairedTexels = 0;
};

/// What the file is follows from its shape; other shapes are refused:
///   2:1       equirectangular
///   1:6, 6:1  six faces +X -X +Y -Y +Z -Z, from top to bottom or from left to right
///   4:3       a cross that lies       3:4  a cross that stands
///                +Y                          +Y
///             -X +Z +X -Z                 -X +Z +X
///                -Y                          -Y
///                                            -Z (upside down: it folds on from -Y)
///             What fills the corners of a cross is never looked at.
///   1:1       one of six files, the others beside it: see faceFiles
Result<LoadedEnvironment> loadEnvironment(const std::filesystem::path& file, const EnvironmentOptions& options);

/// The six files of faces +X -X +Y -Y +Z -Z of which `file` is one by the end of its name before the extension: px nx py ny pz nz, or posx
/// negx posy negy posz negz. Empty where the name ends in none of them. They need not exist.
std::vector<std::filesystem::path> faceFiles(const std::filesystem::path& file);

/// N x 1 texels of equal solid angle, north to south: texel i covers z in [1 - 2(i + 1)/N, 1 - 2i/N].
Result<std::vector<glm::vec3>> loadGradient(const std::filesystem::path& file, const EnvironmentOptions& options);

/// How a painted gradient's numbers mean light. Auto: sRGB where the file's kind is for pictures (PNG, JPEG, TGA, BMP), else linear.
enum class GradientEncoding { Auto, Linear, Srgb };
/// The same of painted files. Under the sRGB curve (which says nothing of primaries: those are of options.colors.source) values lie in
/// [0, 1]; others are refused.
Result<std::vector<glm::vec3>> loadGradient(const std::filesystem::path& file, const EnvironmentOptions& options,
                                            GradientEncoding encoding);

/// The SH that a probes.json of ../shared/data keeps for the probe whose "file" has this name: nine RGB, canonical phase, radiance.
Result<lighting::ShRgb> loadProbeSh(const std::filesystem::path& json, const std::string& probeFileName);

/// A float EXR with the first channelCount (1 .. 4) of R, G, B, A. For `decode` and tests. The file appears whole or not at all.
Result<void> writeExr(const std::filesystem::path& file, ImageView<const glm::vec4> texels, int channelCount);
/// Any image OpenImageIO reads, as RGBA float (missing channels 0, alpha 1), no conversion and no multiplication by alpha; 8 and 16 bits
/// become [0, 1]. channelCount: what the file had; past the fourth they are dropped.
struct PlainImage {
    Image<glm::vec4> texels;
    int channelCount = 0;
};
Result<PlainImage> readImage(const std::filesystem::path& file);
/// An 8-bit RGB PNG, for thumbnails.
Result<std::vector<std::byte>> encodePng(ImageView<const glm::u8vec3> texels);

}  // namespace lightcook::formats
