// Reference values of shaded light at texels of a light map, computed by another program, for instance a path tracer. The verifier compares
// the shading from a cooked scene with them.
#pragma once

#include <filesystem>
#include <glm/vec3.hpp>
#include <vector>

#include "formats/error.h"

namespace lightcook::formats {

struct ShadingValue {
    enum class Kind {
        Lambert,  ///< direction is a normal; value is irradiance, the integral of L(w) max(0, n.w) over the texel's hemisphere
        Specular  ///< direction is a view; value is the radiance that Cook-Torrance (with the lobe of the scene, energy conserving)
                  ///< reflects towards it
    };
    int line = 0;      ///< of the file, from 1
    int x = 0, y = 0;  ///< texel, row 0 on top
    Kind kind = Kind::Lambert;
    double m = 0, f0 = 0;  ///< for Kind::Specular only
    glm::dvec3 direction{0, 0, 1};
    glm::dvec3 value{0};  ///< scene-linear colour of the source space, radiometric
};

/// Reads CSV with the columns x,y,kind,m,f0,dx,dy,dz,r,g,b and a first line that names them; kind is "lambert" or "spec". Normalizes
/// directions. The error for a bad row names its line: other columns, texels outside width x height, m outside (0, 1], f0 outside [0, 1],
/// numbers that are not finite, light below 0 or beyond a float, directions of length 0.
Result<std::vector<ShadingValue>> readShadingValues(const std::filesystem::path& file, int width, int height);

}  // namespace lightcook::formats
