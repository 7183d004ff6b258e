// Colour conversion through OpenColorIO, from the colour space of a file to the working space. lightcook converts only linear quantities,
// so the result is a 3 x 3 matrix; conversions that are not linear are refused. See docs/theory/lighting.md, "Colour".
#pragma once

#include <array>
#include <filesystem>
#include <glm/mat3x3.hpp>
#include <optional>
#include <string>
#include <vector>

#include "formats/error.h"
#include "formats/plain_image.h"
#include "lighting/display.h"

namespace lightcook::formats {

/// Source space of a file that says by itself what its primaries are: `chromaticities` of OpenEXR, PRIMARIES of Radiance. A file that says
/// nothing is in lin_rec709. Not with a config file.
inline constexpr const char* kStatedSource = "stated";

/// The colour spaces of one scene, as scene.toml names them. The built-in config has the scene-linear spaces lin_rec709 (lin_srgb), acescg
/// (lin_ap1), aces2065-1 (lin_ap0), lin_rec2020, lin_p3d65 and lin_ciexyzd65. It also knows the encoded spaces srgb_texture (srgb),
/// g22_rec709 and g24_rec709, only to refuse them by name.
struct ColorSpaces {
    std::string source = "lin_rec709";  ///< or kStatedSource
    std::string working = "lin_rec709";
    std::filesystem::path config;  ///< an OpenColorIO config file; empty: the built-in config

    bool operator==(const ColorSpaces&) const = default;
};

/// A matrix, the luminance weights of the working space (Y of each primary under the white of that space), and linear BT.2020 from the
/// working space. For a config file, both come from its role aces_interchange or, without that role, from its default luma coefficients
/// and the primaries of Rec.709.
struct LinearConversion {
    glm::mat3 workingFromSource{1.0f};
    glm::vec3 luminanceWeights{0.2126f, 0.7152f, 0.0722f};
    glm::dmat3 bt2020FromWorking = lighting::bt2020FromRec709();
    std::optional<glm::dmat3> bt2020FromSource = {};  ///< empty for a config file without the role aces_interchange
    bool isIdentity = true;
};

/// Returns the conversion. Fails for unknown spaces (the error names the nearest known one) and for conversions that are not linear.
/// Linearity is tested with scaled and added colours; the name of a space does not matter.
/// stated  what the file states, which counts for the source kStatedSource: the built-in space with these primaries (see kSamePrimaries),
/// or
///         their own matrix with white adapted to D65. Fails if no space has them.
Result<LinearConversion> linearConversion(const ColorSpaces& spaces, const std::optional<StatedChromaticities>& stated = {});

/// Returns the files that a config file refers to for the conversion, such as the matrix of a FileTransform, sorted. Empty where
/// linearConversion() fails.
std::vector<std::filesystem::path> filesOfConversion(const ColorSpaces& spaces);

/// Fails for a space that linearConversion() refuses whatever the other one is: unknown, of data, or not linear. Succeeds where the config
/// file cannot be read; linearConversion() says why.
Result<void> checkColorSpace(const std::string& name, const std::filesystem::path& config);

/// Returns linear BT.2020 from the linear space whose primaries and white have these chromaticities: CIE x, y of red, green, blue and
/// white. Its white is adapted to D65, except that of CIE XYZ, as in lin_ciexyzd65. Empty if no space has them.
std::optional<glm::dmat3> bt2020FromChromaticities(const StatedChromaticities& chromaticities);

/// The primaries that a file states, compared with those of its source space.
struct StatedPrimaries {
    StatedChromaticities chromaticities{};
    std::string space;      ///< the built-in space that has them; empty: none has
    double difference = 0;  ///< largest difference of an entry of the two matrices to linear BT.2020
};
/// Difference up to which two matrices to linear BT.2020 count as those of one space: more than the choice of a chromatic adaptation, less
/// than the difference between acescg and lin_rec2020.
inline constexpr double kSamePrimaries = 0.01;

/// Returns the comparison. Empty if no space has the chromaticities, or if the matrix of the source space is not known.
std::optional<StatedPrimaries> statedPrimaries(const StatedChromaticities& chromaticities, const LinearConversion& conversion);
/// Returns the chromaticities that an OpenEXR or Radiance file states. Empty: none, or another file.
std::optional<StatedChromaticities> statedChromaticities(const std::filesystem::path& image);
/// Returns the comparison for an image. Empty too if it states no chromaticities.
std::optional<StatedPrimaries> statedPrimaries(const std::filesystem::path& image, const ColorSpaces& spaces);

}  // namespace lightcook::formats
