// Error of decoded texels against the texels that were encoded.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/vec4.hpp>
#include <span>

#include "formats/image.h"
#include "formats/pixel_format.h"

namespace lightcook::bench {

/// Figures over the significant texels and the channels that the format holds. Float formats count three: their alpha is constant here.
struct Figures {
    std::int64_t texels = 0;
    /// Float formats: log2-PSNR, 20 log10(1 / logRmse). Others: 20 log10(1 / rms of the difference). At most 120, also for exact results.
    double psnrDb = 0;
    double logRmse = 0;      ///< rms of f(x') - f(x), f(x) = sign(x) log2(1 + |x|)
    double relRmse = 0;      ///< rms of x' - x over rms of x
    double p99Relative = 0;  ///< 99th percentile of |x' - x| / (|x| + 0.02 key), key the log-average of |x| over values that are not 0
    double maxRelative = 0;  ///< largest |x' - x| / (|x| + 0.02 key)
};

/// Compares decoded texels with those that were encoded.
/// channelWeights  of the squared errors in psnrDb and logRmse; only their ratios count
Figures measure(formats::PixelFormat format, formats::ImageView<const glm::vec4> reference, formats::ImageView<const float> significance,
                formats::ImageView<const glm::vec4> decoded, const std::array<float, 4>& channelWeights = {1, 1, 1, 1});

/// Decodes a whole image with the verifier's decoder, which shares no code with the encoders.
formats::Image<glm::vec4> decodedByVerifier(formats::PixelFormat format, std::span<const std::byte> bytes, int width, int height);

}  // namespace lightcook::bench
