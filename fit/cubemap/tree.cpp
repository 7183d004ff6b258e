#include "fit/cubemap/tree.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <numbers>

#include "lighting/cube.h"

namespace lightcook::fit {
namespace {

using std::numbers::pi;

constexpr int kLargestCellsPerSide = 2048;
/// Length of a run of texels that is added to one cell as a whole, relative to the cell's width. The part beyond its edge stays within
/// `radius`.
constexpr double kRunPerCell = 0.25;

class Splatter {
public:
    explicit Splatter(int cellsPerSide)
        : side_(cellsPerSide), sums_(6 * static_cast<std::size_t>(cellsPerSide) * static_cast<std::size_t>(cellsPerSide)) {}

    /// Adds a piece.
    /// direction  mean over the piece, not normalised
    /// radiance   relative to the brightest
    void add(const glm::dvec3& direction, double solidAngle, const glm::dvec3& radiance) {
        CellMoments& sums = sums_[indexOf(direction)];
        const glm::dvec3 flux = solidAngle * radiance;
        const double brightness = flux.x + flux.y + flux.z;
        sums.solidAngle += solidAngle;
        sums.brightness += brightness;
        sums.direction += solidAngle * direction;
        for (std::size_t c = 0; c < 3; ++c) sums.fluxDirection[c] += flux[static_cast<int>(c)] * direction;
        sums.flux += flux;
    }
    /// Adds several pieces to the cell of their mean direction.
    void add(const CellMoments& pieces) { sums_[indexOf(pieces.direction)].add(pieces); }
    std::vector<CellMoments> take() { return std::move(sums_); }

private:
    std::size_t indexOf(const glm::dvec3& direction) const {
        const lighting::CubeCoordinate at = lighting::cubeFromDirection(direction);
        const auto cellOf = [&](double u) { return std::clamp(static_cast<int>((u + 1) * 0.5 * side_), 0, side_ - 1); };
        return static_cast<std::size_t>((at.face * side_ + cellOf(at.uv.y)) * side_ + cellOf(at.uv.x));
    }

    int side_;
    std::vector<CellMoments> sums_;
};

int pieceCount(double width, double pieceWidth) {
    return std::max(1, static_cast<int>(std::ceil(width / pieceWidth)));
}

/// A row of a panorama. The mean direction of a piece at column angle psi is (across sin(psi), up, -across cos(psi)).
struct PanoramaRow {
    double across, up, solidAngle;
    const std::vector<glm::dvec2>& azimuths;  ///< sin(psi), -cos(psi) of each piece
    glm::dvec3 directionAt(std::size_t column) const { return {across * azimuths[column].x, up, across * azimuths[column].y}; }
};

/// Returns the exact moments of the columns [begin, end).
CellMoments sumOfRun(const PanoramaRow& row, const glm::vec3* texels, double scale, int begin, int end) {
    glm::dvec3 radiance(0);
    glm::dvec2 turn(0);
    std::array<glm::dvec2, 3> fluxTurn{};
    for (int column = begin; column < end; ++column) {
        const glm::dvec3 texel(texels[column]);
        const glm::dvec2 azimuth = row.azimuths[static_cast<std::size_t>(column)];
        radiance += texel;
        turn += azimuth;
        for (std::size_t c = 0; c < 3; ++c) fluxTurn[c] += texel[static_cast<int>(c)] * azimuth;
    }
    const double count = end - begin, brightness = scale * (radiance.x + radiance.y + radiance.z);
    CellMoments sums;
    sums.solidAngle = count * row.solidAngle;
    sums.brightness = row.solidAngle * brightness;
    sums.direction = row.solidAngle * glm::dvec3(row.across * turn.x, count * row.up, row.across * turn.y);
    for (std::size_t c = 0; c < 3; ++c)
        sums.fluxDirection[c] = row.solidAngle * scale *
                                glm::dvec3(row.across * fluxTurn[c].x, radiance[static_cast<int>(c)] * row.up, row.across * fluxTurn[c].y);
    sums.flux = row.solidAngle * scale * radiance;
    return sums;
}

/// runWidth  [rad] length of the runs of texels that are added as a whole
void splatEquirectangular(formats::ImageView<const glm::vec3> texels, double scale, double pieceWidth, double runWidth,
                          Splatter& splatter) {
    const int rowPieces = pieceCount(pi / texels.height, pieceWidth);
    const int rowCount = texels.height * rowPieces;
    std::vector<glm::dvec2> azimuths;  // (sine, -cosine) at the centres of the pieces of a row
    for (int row = 0; row < rowCount; ++row) {
        const double begin = pi * row / rowCount, end = pi * (row + 1) / rowCount;
        const double middle = 0.5 * (begin + end);
        // Rows are shorter towards the poles and need fewer pieces.
        const int columnPieces = pieceCount(2 * pi * std::sin(middle) / texels.width, pieceWidth);
        const int columnCount = texels.width * columnPieces;
        const double measure = 2 * std::sin(middle) * std::sin(0.5 * (end - begin));  // integral of sin(theta)
        const double solidAngle = measure * 2 * pi / columnCount;
        // Components of a mean direction: integrals of sin^2 and sin cos over theta, of cos(psi) over psi.
        const double across =
            (0.5 * (end - begin) - 0.25 * (std::sin(2 * end) - std::sin(2 * begin))) * std::sin(pi / columnCount) / (pi / columnCount);
        const double up = 0.5 * std::sin(begin + end) * std::sin(end - begin);
        if (azimuths.size() != static_cast<std::size_t>(columnCount)) {
            azimuths.clear();
            for (int column = 0; column < columnCount; ++column) {
                const double psi = 2 * pi * (column + 0.5) / columnCount - pi;
                azimuths.emplace_back(std::sin(psi), -std::cos(psi));
            }
        }
        const PanoramaRow line{across / measure, up / measure, solidAngle, azimuths};
        const glm::vec3* source = texels.row(row / rowPieces);
        const int run = static_cast<int>(std::clamp(runWidth * columnCount / (2 * pi * std::sin(middle)), 1.0, columnCount / 8.0 + 1));
        if (columnPieces == 1 && run > 1) {
            for (int first = 0; first < columnCount; first += run)
                splatter.add(sumOfRun(line, source, scale, first, std::min(first + run, columnCount)));
            continue;
        }
        for (int column = 0; column < columnCount; ++column)
            splatter.add(line.directionAt(static_cast<std::size_t>(column)), solidAngle, scale * glm::dvec3(source[column / columnPieces]));
    }
}

void splatCubeStrip(formats::ImageView<const glm::vec3> texels, double scale, double pieceWidth, Splatter& splatter) {
    const int pieces = pieceCount(2.0 / texels.width, pieceWidth);
    const int side = texels.width * pieces;
    std::vector<double> corners(static_cast<std::size_t>(side + 1)), next(corners.size());
    const auto edge = [&](int i) { return 2.0 * i / side - 1; };
    for (int row = 0; row < side; ++row) {
        for (int i = 0; i <= side; ++i) {
            corners[static_cast<std::size_t>(i)] = lighting::cubeCornerSolidAngle(edge(i), edge(row));
            next[static_cast<std::size_t>(i)] = lighting::cubeCornerSolidAngle(edge(i), edge(row + 1));
        }
        for (int column = 0; column < side; ++column) {
            const auto i = static_cast<std::size_t>(column);
            const double solidAngle = next[i + 1] - next[i] - corners[i + 1] + corners[i];
            const glm::dvec2 centre(0.5 * (edge(column) + edge(column + 1)), 0.5 * (edge(row) + edge(row + 1)));
            const double length = 1 - std::min(0.5, solidAngle / 12);  // length of the mean direction of a small square
            for (int face = 0; face < 6; ++face) {
                const glm::vec3& radiance = texels.at(column / pieces, face * texels.width + row / pieces);
                splatter.add(length * lighting::directionFromCube({face, centre}), solidAngle, scale * glm::dvec3(radiance));
            }
        }
    }
}

/// Returns the variance of unit vectors around their mean for each of two axes: (1 - |mean|^2) / 2.
float spreadOf(const glm::dvec3& sum, double weight) {
    const double length = glm::length(sum) / weight;
    return static_cast<float>(std::max(0.0, 0.5 * (1 - length * length)));
}

glm::vec3 unitOr(const glm::dvec3& vector, const glm::vec3& fallback) {
    const double length = glm::length(vector);
    return length > 0 ? glm::vec3(vector / length) : fallback;
}

MomentLevel levelOf(std::vector<CellMoments> moments, int cellsPerSide) {
    return {cellsPerSide, std::sqrt(4 * pi / 6) / cellsPerSide, std::move(moments)};
}

CellLevel finishLevel(const MomentLevel& moments) {
    CellLevel level;
    const int cellsPerSide = level.cellsPerSide = moments.cellsPerSide;
    level.size = moments.size;
    // Half the diagonal of the widest cell, at the centre of a face, and a little more since a centroid is not in the middle.
    level.radius = std::min(2.0, 1.3 * std::numbers::sqrt2 / std::sqrt(cellsPerSide * cellsPerSide + 1.0));
    level.cells.reserve(moments.cells.size());
    for (const CellMoments& cell : moments.cells) level.cells.push_back(finishCell(cell));
    return level;
}

std::vector<CellMoments> mergeFour(const std::vector<CellMoments>& fine, int coarseSide) {
    const auto side = static_cast<std::size_t>(coarseSide);
    std::vector<CellMoments> coarse(6 * side * side);
    for (std::size_t row = 0; row < 6 * side; ++row) {
        for (std::size_t x = 0; x < side; ++x) {
            const std::size_t first = 2 * row * 2 * side + 2 * x;
            CellMoments& sums = coarse[row * side + x];
            sums = fine[first];
            sums.add(fine[first + 1]);
            sums.add(fine[first + 2 * side]);
            sums.add(fine[first + 2 * side + 1]);
        }
    }
    return coarse;
}

}  // namespace

formats::Result<void> checkShape(const formats::Environment& environment, const std::string& subject) {
    const int width = environment.texels.width(), height = environment.texels.height();
    const bool isStrip = environment.projection == formats::Environment::Projection::CubeStrip;
    if (width >= 1 && height >= 1 && (!isStrip || height == 6 * width)) return {};
    return formats::failure(formats::ErrorCode::WrongShape, subject + ", environment",
                            "found " + std::to_string(width) + " x " + std::to_string(height) + " texels, expected " +
                                (isStrip ? "six faces, one above the other" : "at least one"));
}

Cell finishCell(const CellMoments& moments) {
    Cell cell;
    cell.solidAngle = static_cast<float>(moments.solidAngle);
    cell.areaCentroid = unitOr(moments.direction, glm::vec3(0));
    const glm::dvec3 bright = moments.fluxDirection[0] + moments.fluxDirection[1] + moments.fluxDirection[2];
    cell.fluxCentroid = moments.brightness > 0 ? unitOr(bright, cell.areaCentroid) : cell.areaCentroid;
    cell.flux = glm::vec3(moments.flux);
    cell.areaSpread = moments.solidAngle > 0 ? spreadOf(moments.direction, moments.solidAngle) : 0;
    cell.fluxSpread = moments.brightness > 0 ? spreadOf(bright, moments.brightness) : cell.areaSpread;
    for (int c = 0; c < 3; ++c) {
        const auto i = static_cast<std::size_t>(c);
        const bool isLit = moments.flux[c] > 0;
        cell.channelCentroid[i] = isLit ? unitOr(moments.fluxDirection[i], cell.fluxCentroid) : cell.fluxCentroid;
        cell.channelSpread[c] = isLit ? spreadOf(moments.fluxDirection[i], moments.flux[c]) : cell.fluxSpread;
        cell.colourShift = std::max(cell.colourShift, cell.flux[c] * glm::distance(cell.channelCentroid[i], cell.fluxCentroid));
    }
    return cell;
}

MomentTree buildMomentTree(const formats::Environment& environment, double cellWidth, double pieceWidth) {
    assert(cellWidth > 0 && pieceWidth > 0);
    const formats::ImageView<const glm::vec3> texels = environment.texels.view();
    MomentTree tree;
    for (const glm::vec3& texel : environment.texels.texels()) tree.brightest = std::max({tree.brightest, texel.x, texel.y, texel.z});
    const double scale = tree.brightest > 0 ? 1 / static_cast<double>(tree.brightest) : 0;

    int side = 1;
    while (side < kLargestCellsPerSide && std::sqrt(4 * pi / 6) / side > cellWidth) side *= 2;
    Splatter splatter(side);
    if (environment.projection == formats::Environment::Projection::Equirectangular) {
        splatEquirectangular(texels, scale, pieceWidth, kRunPerCell * cellWidth, splatter);
    } else {
        splatCubeStrip(texels, scale, pieceWidth, splatter);
    }
    tree.levels.push_back(levelOf(splatter.take(), side));
    for (side /= 2; side >= 1; side /= 2) tree.levels.push_back(levelOf(mergeFour(tree.levels.back().cells, side), side));
    std::reverse(tree.levels.begin(), tree.levels.end());
    return tree;
}

CellTree buildCellTree(const formats::Environment& environment, double cellWidth, double pieceWidth) {
    MomentTree moments = buildMomentTree(environment, cellWidth, pieceWidth);
    CellTree tree;
    tree.brightest = moments.brightest;
    for (MomentLevel& level : moments.levels) {
        tree.levels.push_back(finishLevel(level));
        level.cells = {};  // frees the memory before the next level needs its own
    }
    return tree;
}

}  // namespace lightcook::fit
