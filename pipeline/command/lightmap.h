// lightcook lightmap: one SH light map.
#pragma once

#include <optional>

#include "formats/light_map.h"
#include "pipeline/command/converter.h"

namespace lightcook::pipeline {

struct LightMapOptions : ConverterOptions {
    formats::LightMapDescription description;
    bool noNormalMaps = false, noSpecular = false;                   ///< the surfaces need no such light
    std::optional<double> normalMapTilt = {};                        ///< largest angle of their normal maps [degrees]
    lighting::SpecularLobe lobe = lighting::SpecularLobe::Beckmann;  ///< one of formats::sceneLobes()
};

Outcome convertLightMap(const LightMapOptions& options, const RunState& state);

/// Returns a scene that holds the light map alone, with the closed fit of its dominant light.
Scene lightMapScene(const ConverterOptions& options, const formats::LightMapDescription& description);

}  // namespace lightcook::pipeline
