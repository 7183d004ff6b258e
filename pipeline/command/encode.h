// lightcook encode: an image as a GPU texture.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>

#include "compress/encode.h"
#include "formats/error.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

struct EncodeCommand {
    std::filesystem::path input, output;
    std::string format;
    std::optional<int> effort = {};  ///< default: 5; without effect on formats without blocks
    bool cube = false;               ///< the input is a vertical strip of six faces
    bool zstd = false;
    /// Replaces infinity by the largest value of the format, NaN and negatives in unsigned formats by zero, and counts them, instead of
    /// refusing them.
    bool repair = false;
    std::optional<compress::HdrMetric> metric = {};  ///< default: log; BC6H and RGB9E5 only
    std::optional<float> metricScale = {};           ///< default: 1; 1e-6 .. 65504; see HdrMetric
    /// Finite, >= 0, one of the format's channels above 0; only ratios count. Default: all 1; formats that code channels together only.
    std::optional<std::array<float, 4>> channelWeights = {};
    bool perceptual = false;                  ///< compress::kLumaWeights in place of channelWeights
    double rdo = 0;                           ///< see compress::EncodeOptions; BC formats only
    std::optional<std::string> source = {};   ///< colour space of an EXR or HDR image; empty: what the file states
    std::filesystem::path significance = {};  ///< image whose first channel weighs the texels; empty: all alike; formats of blocks only
};

/// Returns {"width","height","mips","layers","faces","format","bytes","encode_seconds","threads","clamped_high","clamped_negative",
/// "repaired","transparent_texels","ignored_channels","converted_from"}. transparent_texels are those of an image with alpha that the
/// format does not hold; converted_from is the colour space, "stated" for primaries of none; empty for an image that was not converted.
formats::Result<Json> encodeTexture(const EncodeCommand& command, int threads);

}  // namespace lightcook::pipeline
