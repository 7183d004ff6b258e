// lightcook rsrm: the radially symmetric reflection map of one gradient.
#pragma once

#include <string>
#include <vector>

#include "pipeline/command/converter.h"

namespace lightcook::pipeline {

struct RsrmOptions : ConverterOptions {
    std::vector<double> exponents;  ///< Phong exponents, one row each; empty: the scene's default ones
    std::vector<double> axis;       ///< x, y, z: the input is an environment, averaged around this direction; empty: a gradient
    std::string encoding = "auto";  ///< one of kGradientEncodings
    std::string format;             ///< one of rsrmFormatChoices(); empty: see rsrmFormatsToTry
    int zones = 256;                ///< of the average around the axis
    bool dither = false;
};

Outcome convertRsrm(const RsrmOptions& options, const RunState& state);

}  // namespace lightcook::pipeline
