// lightcook cubemap --filter irradiance and --filter sh: diffuse light of an environment as a small cubemap in one texture file, or as
// nine coefficients in a JSON file.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "formats/error.h"
#include "formats/target.h"
#include "pipeline/assets/textures.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

struct IrradianceCommand {
    std::filesystem::path input, output;  ///< output: .ktx2
    double wrap = 0;                      ///< in [0, 1]: see fit::IrradianceOptions
    int size = 32;                        ///< [texels] of a face's edge
    formats::Target target = formats::Target::Bc;
    bool repair = false;
    std::optional<std::string> source = {};    ///< colour space of the input; empty: what the file states
    double maxError = 0.1;                     ///< limit on the RMS error against brute force, as a fraction
    std::optional<std::uint64_t> budgetBytes;  ///< of GPU memory
    TextureSettings textures;
};

/// Writes one level of six faces: the exit radiance of a white surface, divided by "range" (metadata io.lightcook). Then reopens the file
/// and compares texels with the sum over every source texel. If the error is over maxError, or the texture over the budget, the
/// command fails and an earlier file at the output stays. Returns
/// {"texels","rel_rms","worst","bytes","range","repaired_texels","convert_cpu_seconds", "verify_cpu_seconds"}; the seconds are those of the
/// whole process up to the verification, and of the verification alone.
formats::Result<Json> cookIrradiance(const IrradianceCommand& command);

struct ShCommand {
    std::filesystem::path input, output;  ///< output: .json
    double wrap = 0;                      ///< in [0, 1]
    std::string normalize = "none";       ///< none; or d3dx: times 16/17, so that a game light of 1 is 1 through nine coefficients
    bool repair = false;
    std::optional<std::string> source = {};  ///< colour space of the input; empty: what the file states
};

/// Writes and returns {"sh","exit","wrap","normalize","phase": "none","repaired_texels"}. "sh" is the incident radiance, nine rows of R, G
/// and B. "exit" is the same times the bands of wrapped Lambert: sum exit_i Y_i(n) is the exit radiance of a white surface.
formats::Result<Json> cookSh(const ShCommand& command);

}  // namespace lightcook::pipeline
