// The single converters: a scene of one asset, put together in memory and cooked like any other, verdict included.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/cook/cook.h"

namespace lightcook::pipeline {

struct ConvertOptions {
    std::string converter;  ///< lightmap, dominant, cubemap, lut or rsrm
    std::filesystem::path input, output, sh;
    std::string phase = "none", frame = "world", quantity = "radiance", lightUnits = "radiometric", fit = "closed";
    std::vector<double> exponents, m, axis;
    std::string encoding = "auto", rsrmFormat = "rgba8";
    int zones = 256;
    bool dither = false;
    TableSettings tables;  ///< lut
    double fireflyLimit = formats::LightMapDescription{}.fireflyLimit;
    bool repair = false;
    bool explain = false;  ///< dominant: also where one light cannot say what the map holds
    CookOptions cook;      ///< what lies over [output]
};

/// explainDominant of the input, as the options describe it.
formats::Result<Json> explain(const ConvertOptions& options, const RunState& state);

/// output: a folder as `cook` leaves it; or a .ktx2 or .dds file, where the asset is one texture.
Outcome convert(const ConvertOptions& options, const RunState& state);

}  // namespace lightcook::pipeline
