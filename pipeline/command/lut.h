// lightcook lut: tables of area-specular light.
#pragma once

#include <vector>

#include "formats/error.h"
#include "pipeline/command/converter.h"

namespace lightcook::pipeline {

struct LutOptions : ConverterOptions {
    std::vector<double> m;          ///< range of roughness: low, high; empty: the scene's default range
    std::vector<double> exponents;  ///< the same range as cosine powers, for the lobe phong-power
    TableSettings tables;
    lighting::SpecularLobe lobe = lighting::SpecularLobe::Beckmann;
};

Outcome convertLut(const LutOptions& options, const RunState& state);

}  // namespace lightcook::pipeline
