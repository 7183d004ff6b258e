// The source of a prefilter as the cells of a quadtree on the six faces of a cube. Internal to fit/cubemap.
#pragma once

#include <array>
#include <cstddef>
#include <glm/vec3.hpp>
#include <string>
#include <vector>

#include "formats/environment.h"
#include "formats/error.h"

namespace lightcook::fit {

struct Cell {
    glm::vec3 areaCentroid{0};  ///< unit; weighted by solid angle
    float solidAngle = 0;       ///< [sr]; 0: empty
    glm::vec3 fluxCentroid{0};  ///< unit; weighted by the sum of the channels' flux; areaCentroid if the cell is black
    glm::vec3 flux{0};          ///< [radiance sr], relative to the brightest value of the source
    float areaSpread = 0;       ///< [chord^2] variance of the area around its centroid, per axis of the tangent plane
    float fluxSpread = 0;       ///< the same of the flux around its centroid
    /// The same for the flux of each channel: light sources of different colours may lie side by side in a cell.
    std::array<glm::vec3, 3> channelCentroid{};
    glm::vec3 channelSpread{0};
    /// Largest distance of a channel's centroid from fluxCentroid times the channel's flux [chord radiance sr].
    float colourShift = 0;
};

/// Calls add(centroid, spread, solidAngle, flux) for each entry that represents a cell: one for solid angle and flux at the flux's
/// centroid; two with separate centroids (isSplit); or four with one for each channel (isColoured).
template <class Add>
void enterCell(const Cell& cell, bool isColoured, bool isSplit, Add&& add) {
    if (!isColoured && !isSplit) {
        add(cell.fluxCentroid, cell.fluxSpread, cell.solidAngle, cell.flux);
        return;
    }
    add(cell.areaCentroid, cell.areaSpread, cell.solidAngle, glm::vec3(0));
    if (!isColoured) {
        add(cell.fluxCentroid, cell.fluxSpread, 0.0f, cell.flux);
        return;
    }
    for (int c = 0; c < 3; ++c) {
        glm::vec3 flux(0);
        flux[c] = cell.flux[c];
        add(cell.channelCentroid[static_cast<std::size_t>(c)], cell.channelSpread[c], 0.0f, flux);
    }
}

/// Sums over the pieces of texels in a cell.
struct CellMoments {
    double solidAngle = 0, brightness = 0;  ///< [sr]; sum of the channels' flux
    glm::dvec3 direction{0}, flux{0};
    std::array<glm::dvec3, 3> fluxDirection{};  ///< by channel
    void add(const CellMoments& other) {
        solidAngle += other.solidAngle;
        brightness += other.brightness;
        direction += other.direction;
        flux += other.flux;
        for (std::size_t c = 0; c < 3; ++c) fluxDirection[c] += other.fluxDirection[c];
    }
};
/// Returns the centroids and spreads of a cell from its sums.
Cell finishCell(const CellMoments& moments);

/// Cells of one size: cellsPerSide^2 on each of six faces.
template <class T>
struct CellGrid {
    int cellsPerSide = 0;
    double size = 0;  ///< [chord] root of a cell's mean solid angle
    std::vector<T> cells;
    const T& at(int face, int x, int y) const {
        const auto side = static_cast<std::size_t>(cellsPerSide);
        return cells[(static_cast<std::size_t>(face) * side + static_cast<std::size_t>(y)) * side + static_cast<std::size_t>(x)];
    }
};

/// Cells as sums. A user that needs few of them finishes these alone, which is a quarter of the work.
using MomentLevel = CellGrid<CellMoments>;
struct MomentTree {
    float brightest = 0;              ///< source value of a flux of 1
    std::vector<MomentLevel> levels;  ///< from 1 x 1 a face to the finest
};

struct CellLevel : CellGrid<Cell> {
    double radius = 0;  ///< [chord] largest distance of a point of any cell from its centroid
};
struct CellTree {
    float brightest = 0;            ///< source value of a flux of 1
    std::vector<CellLevel> levels;  ///< from 1 x 1 a face to the finest
};

/// Refuses an environment without texels, or a strip that is not six faces, with ErrorCode::WrongShape.
/// subject  use of the environment, for the error: "cubemap"
formats::Result<void> checkShape(const formats::Environment& environment, const std::string& subject);

/// Returns the tree of an environment. Texels are split into pieces, and each piece is added to its finest cell; the number of cells a side
/// is a power of two. Solid angles and first moments of pieces are exact. Sums are in double and in source order.
/// cellWidth   [rad] largest width of the finest cells
/// pieceWidth  [rad] largest width of a piece
MomentTree buildMomentTree(const formats::Environment& environment, double cellWidth, double pieceWidth);
/// Returns the same tree with every cell finished.
CellTree buildCellTree(const formats::Environment& environment, double cellWidth, double pieceWidth);

}  // namespace lightcook::fit
