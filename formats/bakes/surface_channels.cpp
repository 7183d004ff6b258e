#include "formats/bakes/surface_channels.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>

namespace lightcook::formats {

Result<SurfaceChannels> SurfaceChannels::of(const BakeImage& image, const std::string& coverage) {
    const ExrInfo& info = image.info();
    const auto count = std::ranges::count_if(kNormalChannels, [&](const char* name) { return info.has(name); });
    if (count != 0 && count != 3) {
        return failure(ErrorCode::WrongShape, image.subject(),
                       fmt::format("found {} of the channels normal.X, normal.Y, normal.Z, expected all or none", count));
    }
    SurfaceChannels channels;
    channels.hasNormals_ = count == 3;
    channels.hasCharts_ = info.has(kChartChannel);
    if (info.has(kCoverageChannel))
        channels.coverage_ = kCoverageChannel;
    else if (!coverage.empty() && info.has(coverage))
        channels.coverage_ = coverage;
    return channels;
}

void SurfaceChannels::prepare(RawStrip& raw, int width, int rowCount, std::vector<ExrPlane>& planes) const {
    if (hasCoverage()) {
        raw.coverage = Image<float>(width, rowCount);
        planes.push_back({coverage_, raw.coverage.texels().data(), 1, width});
    }
    if (hasNormals_) {
        raw.normal = Image<glm::vec3>(width, rowCount);
        for (int axis = 0; axis < 3; ++axis)
            planes.push_back({kNormalChannels[static_cast<std::size_t>(axis)], &raw.normal.texels().data()->x + axis, 3, 3 * width});
    }
    if (hasCharts_) {
        raw.chart = Image<float>(width, rowCount);
        planes.push_back({kChartChannel, raw.chart.texels().data(), 1, width});
    }
}

}  // namespace lightcook::formats
