// Shaded light that somebody else computed at texels of a light map, by path tracing for instance: what the shading from a cooked scene is
// held against where nobody doubts the truth.
#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <vector>

#include "formats/error.h"

namespace lightcook::formats {

struct ShadingValue {
    enum class Kind {
        Lambert,  ///< direction is a normal; value is irradiance, the integral of L(w) max(0, n.w) over the texel's hemisphere
        Specular  ///< direction is a view; value is the radiance that Cook-Torrance (Beckmann, energy conserving) reflects towards it
    };
    int line = 0;      ///< in the file, from 1
    int x = 0, y = 0;  ///< texel, row 0 on top
    Kind kind = Kind::Lambert;
    double m = 0, f0 = 0;  ///< specular alone
    glm::dvec3 direction{0, 0, 1};
    glm::dvec3 value{0};  ///< scene-linear colour of the source space, radiometric
};

/// Reads CSV with the columns x,y,kind,m,f0,dx,dy,dz,r,g,b and a first line that names them; kind is "lambert" or "spec". Directions are
/// made unit. Refuses, by line: other columns, texels outside width x height, m outside (0, 1], f0 outside [0, 1], values that are not
/// finite or negative, directions without length.
Result<std::vector<ShadingValue>> readShadingValues(const std::filesystem::path& file, int width, int height);

}  // namespace lightcook::formats
