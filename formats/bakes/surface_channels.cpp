#include "formats/bakes/surface_channels.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace lightcook::formats {
namespace {

const char* const kCoverage = "coverage.Y";
const char* const kChart = "chart.Y";
const char* const kNormal[3] = {"normal.X", "normal.Y", "normal.Z"};

}  // namespace

Result<SurfaceChannels> SurfaceChannels::of(const BakeImage& image, const std::string& coverage) {
    const ExrInfo& info = image.info();
    const auto count = std::count_if(std::begin(kNormal), std::end(kNormal), [&](const char* name) { return info.has(name); });
    if (count != 0 && count != 3) {
        return failure(ErrorCode::WrongShape, image.subject(),
                       fmt::format("found {} of the channels normal.X, normal.Y, normal.Z, expected all or none", count));
    }
    SurfaceChannels channels;
    channels.hasNormals_ = count == 3;
    channels.hasCharts_ = info.has(kChart);
    if (info.has(kCoverage))
        channels.coverage_ = kCoverage;
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
        for (int axis = 0; axis < 3; ++axis) planes.push_back({kNormal[axis], &raw.normal.texels().data()->x + axis, 3, 3 * width});
    }
    if (hasCharts_) {
        raw.chart = Image<float>(width, rowCount);
        planes.push_back({kChart, raw.chart.texels().data(), 1, width});
    }
}

}  // namespace lightcook::formats
