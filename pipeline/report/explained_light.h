// Share of a light map that one dominant light explains, and the share that a second light would add.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/light_map.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// Fits the closed form and the best single light to every covered texel, and two lights to a sample of the texels. Returns for each fit:
///   - the fraction of the energy that it does not explain; energy is the sum of the squares of all coefficients
///   - the distribution of the residual: the norm of a texel's error over the norm of its coefficients, in [0, 1]
/// hasAmbient  each fit has an ambient light too
formats::Result<Json> explainDominant(const std::filesystem::path& file, const formats::LightMapDescription& description, bool hasAmbient,
                                      const RunState& state);

/// Returns the explanation as lines of text.
std::vector<std::string> linesOf(const Json& explanation);

}  // namespace lightcook::pipeline
