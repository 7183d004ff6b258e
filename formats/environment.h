// HDR environments (equirectangular panoramas; six cube faces as strips, crosses or files) and 1-D radially symmetric gradients, from EXR
// or Radiance HDR.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <glm/gtc/type_precision.hpp>
#include <glm/vec3.hpp>
#include <optional>
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
    /// Repairs texels that hold NaN, infinity or a negative value and counts them, instead of refusing the file. +Infinity becomes 65504,
    /// the largest half, or the largest value of the file if that is larger; texels with NaN or a negative value become zero. Channels that
    /// the conversion to the working space makes negative become zero too, and their texels are counted; with the source kStatedSource
    /// also without repair.
    bool repair = false;
};
struct LoadedEnvironment {
    Environment environment;
    std::int64_t repairedTexels = 0;
};

/// Loads a panorama or a cubemap. The shape of the image decides which; other shapes are refused:
///   2:1       equirectangular
///   1:6, 6:1  six faces +X -X +Y -Y +Z -Z, from top to bottom or from left to right
///   4:3       a horizontal cross      3:4  a vertical cross
///                +Y                          +Y
///             -X +Z +X -Z                 -X +Z +X
///                -Y                          -Y
///                                            -Z (upside down: it folds on from -Y)
///             The corners of a cross are ignored.
/// An OpenEXR file with the attribute `envmap` has OpenEXR's directions (ImfEnvmap.h) instead, and is resampled to the above.
///   1:1       one of six files, the others beside it: see faceFiles
Result<LoadedEnvironment> loadEnvironment(const std::filesystem::path& file, const EnvironmentOptions& options);

/// Returns the six files of the faces +X -X +Y -Y +Z -Z. Their names differ in the end before the extension: px nx py ny pz nz, or posx
/// negx posy negy posz negz. Empty if the name of `file` ends in none of these. The files need not exist.
std::vector<std::filesystem::path> faceFiles(const std::filesystem::path& file);

/// Encoding of the values of a painted gradient. Auto: sRGB for PNG, JPEG, TGA and BMP files, else linear.
enum class GradientEncoding { Auto, Linear, Srgb };
struct PaintedGradient {
    std::vector<glm::vec3> zones;  ///< of equal solid angle, north to south: zone i covers z in [1 - 2(i + 1)/N, 1 - 2i/N]
    std::int64_t repairedTexels = 0;
};
/// Loads a painted gradient, N x 1 texels. Values under the sRGB curve must lie in [0, 1]; their primaries are those of
/// options.colors.source.
Result<PaintedGradient> loadPaintedGradient(const std::filesystem::path& file, const EnvironmentOptions& options,
                                            GradientEncoding encoding = GradientEncoding::Linear);

/// Loads the SH that a probes.json holds for the probe whose "file" has this name: nine RGB coefficients of radiance in canonical form.
Result<lighting::ShRgb> loadProbeSh(const std::filesystem::path& json, const std::string& probeFileName);
/// Loads the "position" that it states there, in world space; empty if it states none.
Result<std::optional<glm::dvec3>> loadProbePosition(const std::filesystem::path& json, const std::string& probeFileName);

}  // namespace lightcook::formats
