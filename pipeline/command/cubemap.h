// lightcook cubemap: one environment, prefiltered for specular light, or as diffuse light (irradiance.h).
#pragma once

#include <filesystem>

#include "pipeline/command/converter.h"

namespace lightcook::pipeline {

struct CubemapOptions : ConverterOptions {
    lighting::SpecularLobe lobe = lighting::SpecularLobe::Beckmann;  ///< one of formats::sceneLobes()
    std::filesystem::path sh;                                        ///< JSON with the environment's SH; empty: projected from the image
};

/// Cooks the prefiltered and pre-divided levels of an environment.
Outcome convertCubemap(const CubemapOptions& options, const RunState& state);

}  // namespace lightcook::pipeline
