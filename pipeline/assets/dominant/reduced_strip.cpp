#include "pipeline/assets/dominant/reduced_strip.h"

#include <algorithm>
#include <cassert>
#include <glm/geometric.hpp>

namespace lightcook::pipeline {
namespace {

/// Texels of a map under one texel of a smaller texture, along one axis. Positions are in units of 1 / (texels of the texture) of a texel
/// of the map, so that both grids lie on integers.
class Footprint {
public:
    Footprint(int texel, int mapTexels, int textureTexels)
        : begin_(texel * mapTexels), end_((texel + 1) * mapTexels), unit_(textureTexels) {}

    int firstTexel() const { return begin_ / unit_; }
    int endTexel() const { return (end_ + unit_ - 1) / unit_; }
    /// Returns the part of a texel of the map that lies under the texel of the texture, in (0, 1].
    float partOf(int mapTexel) const {
        return static_cast<float>(std::min(end_, (mapTexel + 1) * unit_) - std::max(begin_, mapTexel * unit_)) / static_cast<float>(unit_);
    }

private:
    int begin_, end_, unit_;
};

/// Sets texel (x, y) of `out` to the mean of the covered texels of `strip` under two footprints.
void reduceTexel(const formats::LightMapStrip& strip, const Footprint& across, const Footprint& down, int x, int y,
                 formats::LightMapStrip& out) {
    lighting::ShRgb sum{};
    glm::vec3 normals(0), firstNormal(0, 0, 1);
    float weights = 0;
    const bool hasCharts = strip.chart.width() > 0;
    std::uint32_t chart = formats::kAnyChart;
    for (int mapY = down.firstTexel(); mapY < down.endTexel(); ++mapY)
        for (int mapX = across.firstTexel(); mapX < across.endTexel(); ++mapX) {
            const int row = mapY - strip.firstRow;
            if (strip.covered.at(mapX, row) == 0) continue;
            const float weight = across.partOf(mapX) * down.partOf(mapY);
            if (weights == 0) firstNormal = strip.normal.at(mapX, row);
            if (hasCharts) chart = weights == 0 || chart == strip.chart.at(mapX, row) ? strip.chart.at(mapX, row) : formats::kAnyChart;
            for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += weight * strip.sh.at(mapX, row)[i];
            normals += weight * strip.normal.at(mapX, row);
            weights += weight;
        }
    if (weights > 0)
        for (auto& coefficient : sum) coefficient /= weights;
    constexpr float kShortest = 1e-3f;  // normals of opposite charts cancel
    out.sh.at(x, y) = sum;
    out.covered.at(x, y) = weights > 0 ? 1 : 0;
    if (hasCharts) out.chart.at(x, y) = chart;
    out.normal.at(x, y) = glm::length(normals) > kShortest ? glm::normalize(normals) : firstNormal;
}

}  // namespace

MapRows rowsUnder(int firstRow, int rowCount, int mapHeight, int textureHeight) {
    const int first = Footprint(firstRow, mapHeight, textureHeight).firstTexel();
    return {first, Footprint(firstRow + rowCount - 1, mapHeight, textureHeight).endTexel() - first};
}

formats::LightMapStrip reducedStrip(const formats::LightMapStrip& strip, int mapHeight, const glm::ivec2& textureSize, int firstRow,
                                    int rowCount) {
    const int width = strip.sh.width();
    formats::LightMapStrip out;
    out.firstRow = firstRow;
    out.sh = formats::Image<lighting::ShRgb>(textureSize.x, rowCount);
    out.covered = formats::Image<std::uint8_t>(textureSize.x, rowCount);
    out.normal = formats::Image<glm::vec3>(textureSize.x, rowCount);
    if (strip.chart.width() > 0) out.chart = formats::Image<std::uint32_t>(textureSize.x, rowCount, formats::kAnyChart);
    for (int y = 0; y < rowCount; ++y) {
        const Footprint down(firstRow + y, mapHeight, textureSize.y);
        assert(down.firstTexel() >= strip.firstRow && down.endTexel() <= strip.firstRow + strip.sh.height());
        for (int x = 0; x < textureSize.x; ++x) reduceTexel(strip, Footprint(x, width, textureSize.x), down, x, y, out);
    }
    return out;
}

}  // namespace lightcook::pipeline
