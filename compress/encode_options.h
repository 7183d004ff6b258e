// Options of the encoders: effort, error metric, channel weights, rate-distortion optimization, instruction set.
#pragma once

#include <array>

namespace lightcook::compress {

/// The domain in which an encoder minimizes the squared error of a floating-point format.
enum class HdrMetric {
    Log,      ///< log2(1 + x / scale): the default; relative error for bright values, absolute error for values below the scale
    Linear,   ///< x
    Relative  ///< dx / (x + scale)
};

/// Weights of squared errors by what a viewer sees of each channel: the luma weights of ITU-R BT.709. Alpha weighs as much as the mean of
/// the colours.
inline constexpr std::array<float, 4> kLumaWeights = {0.2126f, 0.7152f, 0.0722f, 1.0f / 3};

struct EncodeOptions {
    int effort = 5;  ///< 0 (fastest) .. 9 (best)
    HdrMetric hdrMetric = HdrMetric::Log;
    float hdrScale = 1.0f;  ///< the scale in HdrMetric, in the unit of the texels
    std::array<float, 4> channelWeights = {1, 1, 1, 1};
    /// Rate-distortion optimization of BC formats, 0 (off) .. 1: the RMS error of a row of blocks may grow by at most this share, so that
    /// blocks repeat and the file compresses better. Ignored by formats for which supportsRdo is false.
    float rdo = 0;
};

/// The vector instructions that the encoders may use. The bytes do not depend on it; tests force each and compare.
enum class InstructionSet {
    Widest,  ///< the best that this processor has
    Avx2     ///< the minimum that the program is built for
};

/// Sets the instruction set of the whole process. Call it before any encoding.
void allowInstructionSet(InstructionSet set);

}  // namespace lightcook::compress
