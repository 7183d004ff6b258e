// cubemap --filter irradiance and --filter sh: diffuse light of an environment as a small cubemap, in one texture file, or as nine
// coefficients, in a JSON file.
#pragma once

#include <filesystem>

#include "formats/color.h"
#include "formats/error.h"
#include "pipeline/assets/textures.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

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
/// and holds texels against the sum over every source texel. Returns {"texels","rel_rms","worst","bytes","range","repaired_texels",
/// "convert_cpu_seconds","verify_cpu_seconds"}, the seconds of the whole process from its start and of the verification alone; an error
/// over maxError is a failed verification, and leaves what was at the output.
formats::Result<Json> cookIrradiance(const IrradianceCommand& command);

struct ShCommand {
    std::filesystem::path input, output;  ///< output: .json
    double wrap = 0;                      ///< in [0, 1]
    std::string normalize = "none";       ///< none, or d3dx: 16/17 of the light, so that nine coefficients show a game light of 1 as 1
    bool repair = false;
};

/// Writes {"sh": incident radiance, "exit": the same by the bands of wrapped Lambert, so that sum exit_i Y_i(n) is the exit radiance of a
/// white surface, "wrap", "normalize", "phase": "none", "repaired_texels"}, nine rows of R, G and B each, and returns it.
formats::Result<Json> cookSh(const ShCommand& command);

}  // namespace lightcook::pipeline
