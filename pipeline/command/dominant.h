// lightcook dominant: the dominant light of one SH light map.
#pragma once

#include <string>

#include "formats/light_map.h"
#include "pipeline/command/converter.h"

namespace lightcook::pipeline {

struct DominantOptions : ConverterOptions {
    formats::LightMapDescription description;
    std::string fit = "explained";                                   ///< a name of allDominantFits(), or an older one
    std::string layout = "full";                                     ///< a name of allDominantLayouts() with textures
    lighting::SpecularLobe lobe = lighting::SpecularLobe::Beckmann;  ///< one of formats::sceneLobes()
};

Outcome convertDominant(const DominantOptions& options, const RunState& state);

}  // namespace lightcook::pipeline
