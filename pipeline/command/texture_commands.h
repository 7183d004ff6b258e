// encode, decode, compare, info: plain textures and files.
#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>

#include "compress/encode.h"
#include "formats/error.h"
#include "formats/gpu_texture.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

struct EncodeCommand {
    std::filesystem::path input, output;
    std::string format;
    int effort = 5;
    bool cube = false;  ///< the input is a vertical strip of six faces
    bool zstd = false;
    bool repair = false;  ///< NaN becomes zero, negatives in unsigned formats are clamped, both counted; refused otherwise
    compress::HdrMetric metric = compress::HdrMetric::Log;
    float metricScale = 1;                               ///< 1e-6 .. 65504; see HdrMetric
    std::array<float, 4> channelWeights = {1, 1, 1, 1};  ///< finite, >= 0, one of the format's channels above 0; only ratios count
    double rdo = 0;                                      ///< see compress::EncodeOptions; BC formats alone
    std::filesystem::path significance = {};             ///< an image whose first channel weighs the texels; none: all alike
};
/// Returns product.md's facts: {"width","height","mips","layers","faces","format","bytes","encode_seconds","threads"}, and what was
/// clamped.
formats::Result<Json> encodeTexture(const EncodeCommand& command, int threads);

struct DecodeCommand {
    std::filesystem::path input, output;
    int mip = 0, layer = 0;
};
/// Float EXR with the format's channels; a cubemap as a vertical strip of its faces.
formats::Result<void> decodeTexture(const DecodeCommand& command);

/// Two images or textures of one size: {"rmse","rel_rmse","log2_psnr_db","max_abs"}; or two cooked scenes: bytes and error per asset, both
/// and difference.
formats::Result<Json> compareFiles(const std::filesystem::path& a, const std::filesystem::path& b);
/// What a file or a cooked folder holds.
formats::Result<Json> describeFile(const std::filesystem::path& file);

}  // namespace lightcook::pipeline
