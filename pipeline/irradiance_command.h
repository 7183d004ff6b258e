// cubemap --filter irradiance: diffuse light of an environment as a small cubemap, in one texture file.
#pragma once

#include <filesystem>

#include "formats/color.h"
#include "formats/error.h"
#include "pipeline/action.h"
#include "pipeline/textures.h"

namespace pipeline {

struct IrradianceCommand {
    std::filesystem::path input, output;  ///< output: .ktx2 or .dds
    double wrap = 0;                      ///< in [0, 1]: see fit::IrradianceOptions
    int size = 32;                        ///< [texels] of a face
    std::string target = "bc";            ///< bc, astc or float
    bool repair = false;
    double maxError = 0.1;  ///< a fraction: what the file may err from brute force, rms
    TextureSettings textures;
};

/// Writes one level of six faces of the exit radiance of a white surface, over "range" (metadata io.lightcook), then opens the file again
/// and holds texels against the sum over every source texel. Returns {"texels","rel_rms","worst","bytes","range","repaired_texels"}; an
/// error over maxError is a failed verification, and leaves what was at the output.
formats::Result<Json> cookIrradiance(const IrradianceCommand& command);

}  // namespace pipeline
