// The source of a prefilter as cells of a quadtree on the six faces of a cube. Internal to fit/cubemap.
#pragma once

#include <array>
#include <glm/vec3.hpp>
#include <vector>

#include "formats/environment.h"

namespace lightcook::fit {

struct Cell {
    glm::vec3 areaCentroid{0};  ///< unit; weighted by solid angle
    float solidAngle = 0;       ///< [sr]; 0: nothing fell here
    glm::vec3 fluxCentroid{0};  ///< unit; weighted by the sum of the channels' flux; the area's where there is no light
    glm::vec3 flux{0};          ///< [radiance sr], over the source's brightest value
    float areaSpread = 0;       ///< [chord^2] variance of the area around its centroid, per axis of the tangent plane
    float fluxSpread = 0;       ///< the same of the flux around its own
    /// The same of each channel's own light, where lamps of different colours may lie side by side.
    std::array<glm::vec3, 3> channelCentroid{};
    glm::vec3 channelSpread{0};
    /// How far channels' light lies from fluxCentroid, times what it is [chord radiance sr]: the most of the three.
    float colourShift = 0;
};

/// Calls add(centroid, spread, solidAngle, flux) for what a cell is entered as: its channels each where its own light is (isColoured), its
/// light apart from its area (isSplit), or both at the light's centroid.
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

/// What a cell is made of: sums over the pieces of texels in it, in double.
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
Cell finishCell(const CellMoments& moments);

/// Cells of one size that are finished when they are looked at: a quarter of the work where few are.
struct MomentLevel {
    int cellsPerSide = 0;
    double size = 0;  ///< [chord] root of a cell's mean solid angle
    std::vector<CellMoments> cells;
    const CellMoments& at(int face, int x, int y) const {
        return cells[(static_cast<std::size_t>(face) * static_cast<std::size_t>(cellsPerSide) + static_cast<std::size_t>(y)) *
                         static_cast<std::size_t>(cellsPerSide) +
                     static_cast<std::size_t>(x)];
    }
};
struct MomentTree {
    float brightest = 0;              ///< the value of 1 in the cells' fluxes
    std::vector<MomentLevel> levels;  ///< from 1 x 1 a face to the finest
};

/// Cells of one size: cellsPerSide^2 on each of six faces.
struct CellLevel {
    int cellsPerSide = 0;
    double size = 0;    ///< [chord] root of a cell's mean solid angle
    double radius = 0;  ///< [chord] no point of any cell is farther from its centroid
    std::vector<Cell> cells;
    const Cell& at(int face, int x, int y) const {
        return cells[(static_cast<std::size_t>(face) * static_cast<std::size_t>(cellsPerSide) + static_cast<std::size_t>(y)) *
                         static_cast<std::size_t>(cellsPerSide) +
                     static_cast<std::size_t>(x)];
    }
};

struct CellTree {
    float brightest = 0;            ///< the value of 1 in the cells' fluxes
    std::vector<CellLevel> levels;  ///< from 1 x 1 a face to the finest
};

/// Splits texels into pieces no wider than pieceWidth [rad] and drops each into its finest cell (cells as small as cellWidth [rad], a power
/// of two a side); solid angles and first moments of pieces are exact, sums are in double and in source order.
MomentTree buildMomentTree(const formats::Environment& environment, double cellWidth, double pieceWidth);
/// The same with every cell finished.
CellTree buildCellTree(const formats::Environment& environment, double cellWidth, double pieceWidth);

}  // namespace lightcook::fit
