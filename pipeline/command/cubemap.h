// lightcook cubemap: one environment, prefiltered for specular light, or as diffuse light (irradiance.h).
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "pipeline/command/converter.h"

namespace lightcook::pipeline {

struct CubemapOptions : ConverterOptions {
    lighting::SpecularLobe lobe = lighting::SpecularLobe::Beckmann;  ///< one of formats::sceneLobes()
    std::filesystem::path sh;                                        ///< JSON with the environment's SH; empty: projected from the image
    std::optional<int> size;                                         ///< of a face [texels]; none: that of a scene's probe
    std::string layout = ProbeEntry{}.layout;                        ///< a name of allCubemapLayouts()
};

/// Cooks the prefiltered levels of an environment, pre-divided or plain.
Outcome convertCubemap(const CubemapOptions& options, const RunState& state);

}  // namespace lightcook::pipeline
