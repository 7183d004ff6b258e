// Texels in, GPU blocks out: one call for every pixel format. Pure: no thread, no file; callers spread rows of blocks over threads.
// The same texels give the same bytes however the rows were cut, provided cuts fall between blocks.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec4.hpp>
#include <span>

#include "formats/image.h"
#include "formats/pixel_format.h"

namespace lightcook::compress {

/// The domain in which the error of floating-point formats is minimised.
enum class HdrMetric {
    Log,      ///< log2(1 + x / scale): the default, relative for light, calm in the dark
    Linear,   ///< x itself
    Relative  ///< dx / (x + scale)
};

struct EncodeOptions {
    int effort = 5;  ///< 0 (fastest) .. 9 (best)
    HdrMetric hdrMetric = HdrMetric::Log;
    float hdrScale = 1.0f;  ///< see HdrMetric
    std::array<float, 4> channelWeights = {1, 1, 1, 1};
    /// BC formats (others have nothing to repeat): the share by which the root of each row of blocks' weighted squared error may grow so
    /// that blocks repeat and the file compresses better
    float rdo = 0;
};

/// What had to be changed so that the format can hold it: never silently. Texels without significance are not counted.
struct EncodeReport {
    std::int64_t clampedHigh = 0;      ///< channel values above the format's largest, or below minus that in a signed format
    std::int64_t clampedNegative = 0;  ///< negative channel values in an unsigned format
    void add(const EncodeReport& other) {
        clampedHigh += other.clampedHigh;
        clampedNegative += other.clampedNegative;
    }
};

/// Encodes rows of blocks.
/// texels        finite; scene-linear for float formats, in [0, 1] for unorm ones, in [-1, 1] for snorm ones; channels the format has not
/// are ignored.
///               Width and height need not be multiples of the block: missing texels repeat the edge and weigh nothing
/// significance  weight >= 0 of each texel, same extent; a view without texels counts every texel as 1. Where a whole block weighs
///               nothing it is encoded as if all its texels weighed 1
/// out           blocksDown * bytesPerBlockRow bytes
/// decoded       receives what these blocks decode to, same extent; a view without texels asks for nothing
EncodeReport encodeRows(formats::PixelFormat format, formats::ImageView<const glm::vec4> texels,
                        formats::ImageView<const float> significance, const EncodeOptions& options, std::span<std::byte> out,
                        formats::ImageView<glm::vec4> decoded);

}  // namespace lightcook::compress
