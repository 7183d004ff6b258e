#include "compress/block/row_metric.h"

#include <bit>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>

#include "compress/bc6h/search.h"

namespace lightcook::compress {
namespace {

/// Returns log2(1 + x), x >= 0, to 2e-5, by the polynomial of the encoders. Own code, because the bytes must not depend on the rounding of
/// a library.
float log2OfOneAnd(float x) {
    const std::uint32_t bits = std::bit_cast<std::uint32_t>(x + 1);
    const float m = std::bit_cast<float>((bits & 0x7FFFFFu) | 0x3F800000u) - 1;
    float p = kBc6hLog2[4];
    for (std::size_t i = 4; i-- > 0;) p = p * m + kBc6hLog2[i];
    return static_cast<float>(static_cast<int>(bits >> 23) - 127) + m * p;
}

}  // namespace

RowMetric::RowMetric(formats::PixelFormat format, const EncodeOptions& options)
    : range_(rangeOf(format)),
      channelCount_(static_cast<std::size_t>(formats::info(format).channelCount)),
      metric_(formats::info(format).isFloat ? options.hdrMetric : HdrMetric::Linear),
      scale_(options.hdrScale) {}

glm::vec4 RowMetric::inRange(const glm::vec4& texel) const {
    return glm::clamp(texel, range_.low, range_.high);
}

void RowMetric::map(Planes& planes) const {
    if (metric_ != HdrMetric::Log) return;
    for (std::size_t c = 0; c < channelCount_; ++c)
        for (float& value : planes[c]) value = std::copysign(log2OfOneAnd(std::abs(value) / scale_), value);
}

float RowMetric::factor(float value) const {
    if (metric_ != HdrMetric::Relative) return 1;
    const float slope = 1 / (std::abs(value) + scale_);
    return slope * slope;
}

}  // namespace lightcook::compress
