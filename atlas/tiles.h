// Tiles of charts: a grid of squares over each large chart, whose tiles can go to different light maps.
//
// The lines of a chart's grid lie kLineOffset beyond texel centres, from the first of its quads on. So each quad lies in one tile, except
// for a strip of width kLineOffset, which belongs to the tile before it. Light, which is bilinear in each quad, is thus cut at texel
// centres. Lines on the centres themselves would cost two texels: samplers round places, so filters on both sides of a line would read a
// texel beyond it. With the offset only those before the line do.
#pragma once

#include <cstddef>
#include <glm/vec2.hpp>
#include <span>
#include <vector>

#include "atlas/charts.h"

namespace lightcook::atlas {

/// Distance of the lines of a grid from texel centres [texels].
inline constexpr double kLineOffset = 2 * kPlaceRounding;

/// The box around the quads of a chart.
struct ChartBox {
    glm::ivec2 first{0};  ///< lowest quad
    glm::ivec2 quads{0};  ///< size
};

/// The tiles of all charts of a map, numbered chart by chart and then row by row. A number may belong to a square of a chart's box that no
/// triangle reaches.
class Tiles {
public:
    /// charts  in the order of findCharts()
    /// side    of a tile [texels]. The last tile of a row or column is larger by up to a half, so that none is smaller than half a tile.
    ///         0: every chart is one tile
    Tiles(std::span<const ChartBox> charts, int side);

    int side() const { return side_; }
    int count() const { return count_; }
    std::size_t chartCount() const { return grids_.size(); }
    /// Returns the number of tiles of a chart along each axis.
    glm::ivec2 gridOf(std::size_t chart) const { return grids_[chart].tiles; }
    /// Returns the tile at a place of a chart's grid.
    int at(std::size_t chart, const glm::ivec2& place) const {
        const Grid& grid = grids_[chart];
        return grid.number + place.y * grid.tiles.x + place.x;
    }
    /// Returns the tile of a quad. Quads beyond the chart's box are of the nearest tile.
    int ofQuad(std::size_t chart, const glm::ivec2& quad) const;
    /// Returns the coordinate of the line before a column (axis 0) or row (axis 1) of tiles, from 1 on [texels; integers are centres].
    double line(std::size_t chart, int axis, int index) const { return grids_[chart].first[axis] + index * side_ + kLineOffset; }

private:
    struct Grid {
        glm::ivec2 first{0}, tiles{1};
        int number = 0;  ///< of the first tile
    };
    int side_;
    int count_ = 0;
    std::vector<Grid> grids_;
};

/// Returns the boxes of charts.
std::vector<ChartBox> boxesOf(std::span<const Chart> charts);

}  // namespace lightcook::atlas
