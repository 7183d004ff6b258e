// Where one light cannot say what a light map holds, and what a second one would give there.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/light_map.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// Of every covered texel: what is left of its SH by the closed form and by the best single light, as the root of the squared error over
/// the norm of the coefficients (the residual, in [0, 1]); of a sample of them by two lights. Shares are of texels and of energy, the sum
/// of squares of all coefficients. hasAmbient: beside ambient light.
formats::Result<Json> explainDominant(const std::filesystem::path& file, const formats::LightMapDescription& description, bool hasAmbient,
                                      const RunState& state);

/// The same as a table for people.
std::vector<std::string> linesOf(const Json& explanation);

}  // namespace lightcook::pipeline
