// Colour conversion through OpenColorIO: from the space a file is in to the working space. Everything that lightcook conditions is a
// linear quantity, so what comes out is a 3 x 3 matrix, or a refusal by name.
#pragma once

#include <filesystem>
#include <glm/mat3x3.hpp>
#include <string>

#include "formats/error.h"

namespace lightcook::formats {

/// The spaces of one scene, as scene.toml names them. An empty config is our own, built in code: scene-linear spaces by their usual names
/// (lin_rec709 / lin_srgb, acescg / lin_ap1, aces2065-1 / lin_ap0, lin_rec2020, lin_p3d65, lin_ciexyzd65) and the encoded ones people
/// mistake them for (srgb_texture / srgb, g22_rec709, g24_rec709), which are known so that they can be refused by name.
struct ColorSpaces {
    std::string source = "lin_rec709";
    std::string working = "lin_rec709";
    std::filesystem::path config;  ///< an OCIO config file; empty: ours

    bool operator==(const ColorSpaces&) const = default;
};

/// The matrix workingFromSource, and the luminance weights of the working space: Y of each primary under the space's own white. With a
/// config of the user's, Y through its role aces_interchange, or what the config declares as its luma.
struct LinearConversion {
    glm::mat3 workingFromSource{1.0f};
    glm::vec3 luminanceWeights{0.2126f, 0.7152f, 0.0722f};
    bool isIdentity = true;
};

/// Refuses unknown spaces (naming the nearest known one) and transforms that are not linear: found by probing the processor with scaled
/// and added colours, not by the space's name.
Result<LinearConversion> linearConversion(const ColorSpaces& spaces);

}  // namespace lightcook::formats
