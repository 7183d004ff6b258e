#include "pipeline/assets/light_map/surface_places.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <optional>

#include "pipeline/assets/light_map/bake_filter.h"

namespace lightcook::pipeline {
namespace {

/// Places of a map at most, about. The samples of one place are alike: of 2500 places a band of rows is no sample (docs/lab/pipeline.md).
constexpr double kMostSurfacePlaces = 10000;
/// Rows at the ends of a strip that have no places: a filter reads one row more.
constexpr int kFilterRows = 1;

/// Returns the bake at a place, filtered between covered texels. Nothing where charts meet.
/// at  as for mayCrossCharts
std::optional<lighting::ShRgb> bakeAt(const formats::LightMapStrip& texels, const glm::dvec2& at) {
    if (mayCrossCharts(texels, at)) return std::nullopt;
    std::array<glm::dvec3, lighting::kShCount> sum{};
    double weights = 0;
    forEachCoveredAround(texels, at, [&](int x, int row, double weight) {
        for (std::size_t k = 0; k < lighting::kShCount; ++k) sum[k] += weight * glm::dvec3(texels.sh.at(x, row)[k]);
        weights += weight;
    });
    if (!(weights > 0)) return std::nullopt;
    lighting::ShRgb bake;
    for (std::size_t k = 0; k < lighting::kShCount; ++k) bake[k] = glm::vec3(sum[k] / weights);
    return bake;
}

}  // namespace

bool mayCrossCharts(const formats::LightMapStrip& texels, const glm::dvec2& at) {
    const glm::ivec2 corner(glm::floor(at));
    std::array<std::uint32_t, 4> charts{};
    for (int i = 0; i < 4; ++i) {
        const int x = std::clamp(corner.x + i % 2, 0, texels.sh.width() - 1),
                  y = std::clamp(corner.y + i / 2 - texels.firstRow, 0, texels.sh.height() - 1);
        charts[static_cast<std::size_t>(i)] = texels.chart.width() > 0 ? texels.chart.at(x, y) : formats::kAnyChart;
    }
    return !formats::mayHoldSurface(charts);
}

glm::dvec2 placeInTexel(std::int64_t number) {
    constexpr glm::dvec2 kStep(0.75487766624669276, 0.56984029099805327);
    return glm::fract(0.5 + static_cast<double>(number) * kStep) - 0.5;
}

/// The step is odd, so that places fall on every texel of a block.
SurfacePlaces::SurfacePlaces(int width, int height)
    : width_(width),
      height_(height),
      step_(static_cast<int>(std::ceil(std::sqrt(static_cast<double>(width) * height / kMostSurfacePlaces))) | 1) {}

std::vector<SurfacePlace> SurfacePlaces::of(const formats::LightMapStrip& texels, int firstRow, int rowCount, int from, int end) const {
    const int endRow = firstRow + rowCount;
    const int firstPlace = std::max(from, firstRow == 0 ? 0 : firstRow + kFilterRows),
              endPlace = std::min(end, endRow == height_ ? endRow : endRow - kFilterRows);
    const int placesAcross = (width_ + step_ - 1) / step_;
    std::vector<SurfacePlace> places;
    for (int y = firstPlace; y < endPlace; ++y)
        for (int x = step_ / 2; y % step_ == step_ / 2 && x < width_; x += step_) {
            if (texels.covered.at(x, y - texels.firstRow) == 0) continue;
            const glm::dvec2 at = glm::dvec2(x, y) + placeInTexel(y / step_ * placesAcross + x / step_);
            if (const auto bake = bakeAt(texels, at)) places.push_back({at, texels.normal.at(x, y - texels.firstRow), *bake});
        }
    return places;
}

}  // namespace lightcook::pipeline
