#include "atlas/tiles.h"

#include <glm/common.hpp>

namespace lightcook::atlas {

Tiles::Tiles(std::span<const ChartBox> charts, int side) : side_(side) {
    for (const ChartBox& chart : charts) {
        Grid& grid = grids_.emplace_back();
        grid.first = chart.first;
        if (side > 0) grid.tiles = glm::max((chart.quads + side / 2) / side, glm::ivec2(1));
        grid.number = count_;
        count_ += grid.tiles.x * grid.tiles.y;
    }
}

int Tiles::ofQuad(std::size_t chart, const glm::ivec2& quad) const {
    const Grid& grid = grids_[chart];
    if (side_ == 0) return grid.number;
    return at(chart, glm::clamp((quad - grid.first) / side_, glm::ivec2(0), grid.tiles - 1));
}

std::vector<ChartBox> boxesOf(std::span<const Chart> charts) {
    std::vector<ChartBox> boxes;
    for (const Chart& chart : charts) boxes.push_back({chart.first, chart.quads});
    return boxes;
}

}  // namespace lightcook::atlas
