// How far decoded texels are from what was asked for.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/vec4.hpp>
#include <span>

#include "formats/image.h"
#include "formats/pixel_format.h"

namespace lightcook::bench {

/// Over the texels that count and the channels that the format holds (three of ASTC HDR: its alpha is a constant here).
struct Figures {
    std::int64_t texels = 0;
    /// Float formats: log2-PSNR, 20 log10(1 / logRmse). Others: 20 log10(1 / rms of the difference). At most 120, which exact results get.
    double psnrDb = 0;
    double logRmse = 0;      ///< rms of f(x') - f(x), f(x) = sign(x) log2(1 + |x|)
    double relRmse = 0;      ///< rms of x' - x over rms of x
    double p99Relative = 0;  ///< 99th percentile of |x' - x| / (|x| + 0.02 key), key the log-average of |x| over values that are not 0
    double maxRelative = 0;  ///< the largest of the same
};

Figures measure(formats::PixelFormat format, formats::ImageView<const glm::vec4> reference, formats::ImageView<const float> significance,
                formats::ImageView<const glm::vec4> decoded);

/// What the verifier's decoder, which shares nothing with the encoders, makes of the bytes of a whole image.
formats::Image<glm::vec4> decodedByVerifier(formats::PixelFormat format, std::span<const std::byte> bytes, int width, int height);

}  // namespace lightcook::bench
