// The error metric of the encoders, for rate-distortion optimization: a weighted squared difference of mapped values.
#pragma once

#include <array>
#include <cstddef>
#include <glm/vec4.hpp>

#include "compress/block/block.h"
#include "compress/encode_options.h"
#include "compress/texel/packed_texels.h"
#include "formats/pixel_format.h"

namespace lightcook::compress {

/// Sixteen texels in planes, in the space of the metric.
using Planes = std::array<std::array<float, kTexelCount>, 4>;

/// Error of a texel: sum over channels of weight * factor(value) * (map(decoded) - map(value))^2.
class RowMetric {
public:
    RowMetric(formats::PixelFormat format, const EncodeOptions& options);

    /// Returns true if errors are squared differences of the values.
    bool isLinear() const { return metric_ == HdrMetric::Linear; }
    std::size_t channelCount() const { return channelCount_; }
    /// Returns a texel clamped to the range of the format.
    glm::vec4 inRange(const glm::vec4& texel) const;
    /// Maps values into the space of the metric: log2(1 + x / scale) for HdrMetric::Log, else unchanged.
    void map(Planes& planes) const;
    /// Returns the factor of a squared difference at this value: 1 / (x + scale)^2 for HdrMetric::Relative, else 1.
    float factor(float value) const;

private:
    ChannelRange range_;
    std::size_t channelCount_;
    HdrMetric metric_;
    float scale_;
};

}  // namespace lightcook::compress
