// Prefiltered light of one roughness towards many directions.
//
// The integral of kernel times radiance is a sum over tiles of the source. In a tile the kernel is replaced by its polynomial interpolant
// on 8 x 8 Chebyshev nodes, sum_i K(direction . node_i) L_i. What is left of the source is the integral of its radiance times L_i, once for
// all directions: a treecode with interpolation (Wang, Krasny and Tlupova 2020, A kernel-independent treecode based on barycentric Lagrange
// interpolation; section 2). The weights of a parent tile are those of its children through the same interpolation.
//
// A tile is summed by its nodes if it is at most two widths of the kernel across, where the width is sqrt(2) m, and of GGX at least half of
// the distance from the axis, since its tail falls with a power of the angle. The interpolant of degree 7 then errs by less than 1e-4 of
// the kernel's peak: of a Gaussian by 105 (1 / 2^7 8!) = 2e-5. Wide kernels have a kink where they end at the horizon. Tiles across it are
// at most kKinkedStep wide, which leaves 1e-3 of the kernel's peak for light from exactly there.
//
// The texels of the source are squares of even radiance; integrals over them are sums over Gauss points. Nothing is shared with fit/.
#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <memory>
#include <numbers>
#include <span>
#include <utility>

#include "lighting/cube.h"
#include "lighting/sphere.h"
#include "verify/assets/prefilter_kernel.h"
#include "verify/cubemap.h"

namespace lightcook::verify {
namespace {

using formats::Environment;
using lighting::NormalDistribution;

constexpr int kNodes = 8;  ///< along each axis of a tile
constexpr std::size_t kTileNodes = kNodes * kNodes;
using NodeValues = std::array<double, kNodes>;

/// Returns the Chebyshev points of [0, 1].
NodeValues makeNodes() {
    NodeValues nodes{};
    for (int i = 0; i < kNodes; ++i) nodes[static_cast<std::size_t>(i)] = 0.5 - 0.5 * std::cos((i + 0.5) * std::numbers::pi / kNodes);
    return nodes;
}
const NodeValues kNodePlaces = makeNodes();

/// Returns the Lagrange polynomials of the nodes at a place in [0, 1].
NodeValues lagrangeAt(double place) {
    NodeValues values{};
    for (std::size_t i = 0; i < kNodes; ++i) {
        values[i] = 1;
        for (std::size_t j = 0; j < kNodes; ++j)
            if (i != j) values[i] *= (place - kNodePlaces[j]) / (kNodePlaces[i] - kNodePlaces[j]);
    }
    return values;
}

struct GaussPoint {
    double place, weight;  ///< in [0, 1]; weights sum to 1
};
/// Returns the points of a Gauss-Legendre rule of 1, 2, 3 or 5 points.
std::span<const GaussPoint> gaussRule(int count) {
    static constexpr GaussPoint kOne[] = {{0.5, 1}};
    static constexpr GaussPoint kTwo[] = {{0.21132486540518712, 0.5}, {0.78867513459481288, 0.5}};
    static constexpr GaussPoint kThree[] = {{0.11270166537925831, 5.0 / 18}, {0.5, 8.0 / 18}, {0.88729833462074169, 5.0 / 18}};
    static constexpr GaussPoint kFive[] = {{0.046910077030668, 0.11846344252809454},
                                           {0.23076534494715845, 0.23931433524968324},
                                           {0.5, 0.28444444444444444},
                                           {0.76923465505284155, 0.23931433524968324},
                                           {0.953089922969332, 0.11846344252809454}};
    if (count == 1) return kOne;
    if (count == 2) return kTwo;
    if (count == 3) return kThree;
    return kFive;
}

}  // namespace

/// A place of integration along one axis of a tile.
struct PrefilteredLight::Point {
    int texel;              ///< of the source, along the axis
    double place;           ///< u or v of a face, longitude or colatitude [rad]
    double weight;          ///< extent in the same unit
    double sine;            ///< of a panorama's angle
    NodeValues polynomial;  ///< Lagrange polynomials of the tile's nodes
};

/// Tiles of one size, face after face, row after row.
struct PrefilteredLight::Grid {
    int across = 0, down = 0;  ///< tiles of a face, or of the panorama
    double step = 0;           ///< extent of a tile: largest angle [rad]
    bool isKinked = false;     ///< tiles on the horizon are too large for the kernel's kink
    struct Tile {
        glm::dvec3 centre;
        double radius;      ///< [rad]
        double sine;        ///< of the radius
        double outside;     ///< cosines below it are out of the kernel's reach
        double acceptable;  ///< tiles with a cosine up to it are small for their distance
    };
    std::vector<Tile> tiles;
    /// [tile row or column][node] u or v; of a panorama the sine and the cosine of the angle
    std::vector<NodeValues> u, v, sineX, cosineX, sineY, cosineY;
    using Weights = std::vector<std::array<float, 4 * kTileNodes>>;  ///< [tile][solid angle, red, green, blue][node]
    std::shared_ptr<Weights> weights;                                ///< the same for every kernel
};

struct PrefilteredLight::Sums {
    std::array<std::array<double, kNodes>, 4> columns{};  ///< [solid angle, red, green, blue]
};

PrefilteredLight::PrefilteredLight(const Environment& environment, double m, NormalDistribution lobe, const PrefilteredLight* other)
    : environment_(environment),
      isPanorama_(environment.projection == Environment::Projection::Equirectangular),
      m_(m),
      lobe_(lobe),
      support_(kernelSupport(m, lobe)) {
    assert(0 < m && m <= 1);
    constexpr double kWidths = 2, kKinkedStep = 1.0 / 32, kKink = 0.005;
    const bool isGgx = lobe == NormalDistribution::Ggx;
    const double width = std::numbers::sqrt2 * m, squared = m * m;
    // Slope of the kernel where it ends, over its peak.
    const double slope = isGgx ? 4 * squared * squared / ((1 + squared) * (1 + squared)) : 4 * std::exp(-1 / squared);
    narrow_ = kWidths * width;
    double step = narrow_;
    if (slope * std::min(step, 0.25) > kKink) step = std::min(step, kKinkedStep);
    const double extent = isPanorama_ ? std::numbers::pi : 2.0;
    // 4 to 7 coarsest tiles along an edge, so that the finest ones are not much smaller than they need to be.
    int finest = std::max(4, static_cast<int>(std::ceil(extent / step))), doublings = 0;
    while (finest > 7) {
        finest = (finest + 1) / 2;
        ++doublings;
    }
    for (int level = doublings; level >= 0; --level) {
        Grid grid;
        grid.down = finest << level;
        grid.across = isPanorama_ ? 2 * grid.down : grid.down;
        grid.step = extent / grid.down;
        grid.isKinked = slope * grid.step > kKink;
        grids_.push_back(std::move(grid));
    }
    for (const glm::vec3& texel : environment.texels.texels())
        brightest_ = std::max({brightest_, static_cast<double>(texel.x), static_cast<double>(texel.y), static_cast<double>(texel.z)});
    if (!(brightest_ > 0)) brightest_ = 1;
    const auto hasSameTiles = [](const Grid& a, const Grid& b) { return a.down == b.down && a.across == b.across; };
    if (other != nullptr && std::ranges::equal(grids_, other->grids_, hasSameTiles)) {
        assert(&environment == &other->environment_);
        for (std::size_t i = 0; i < grids_.size(); ++i) {
            const bool isKinked = grids_[i].isKinked;
            grids_[i] = other->grids_[i];
            grids_[i].isKinked = isKinked;
        }
    } else {
        integrateGrids();
    }
    for (Grid& grid : grids_) setReach(grid);
}

PrefilteredLight::PrefilteredLight(PrefilteredLight&&) noexcept = default;
PrefilteredLight::~PrefilteredLight() = default;

double PrefilteredLight::edge(const Grid& grid, bool isRow, int tile) const {
    if (isPanorama_) return grid.step * tile - (isRow ? 0 : std::numbers::pi);
    return grid.step * tile - 1;
}

glm::dvec3 PrefilteredLight::directionAt(int face, double x, double y) const {
    if (!isPanorama_) return lighting::directionFromCube({face, {x, y}});
    return {std::sin(y) * std::sin(x), std::cos(y), -std::sin(y) * std::cos(x)};
}

/// Sets what does not depend on the kernel.
void PrefilteredLight::integrateGrids() {
    for (Grid& grid : grids_) place(grid);
    integrate(grids_.front());
    for (std::size_t i = 1; i < grids_.size(); ++i) join(grids_[i - 1], grids_[i]);
}

/// Sets the cosines at which the tiles of a grid are out of the kernel's reach, or small enough.
void PrefilteredLight::setReach(Grid& grid) const {
    const auto cosineOf = [&](double angle) { return angle < std::numbers::pi ? std::cos(angle) : -2.0; };
    for (Grid::Tile& tile : grid.tiles) {
        tile.outside = cosineOf(support_ + tile.radius);
        tile.acceptable = grid.step <= narrow_ ? 2.0 : lobe_ == NormalDistribution::Ggx ? cosineOf(grid.step + tile.radius) : -2.0;
    }
}

/// Fills the places of a grid's tiles and nodes.
void PrefilteredLight::place(Grid& grid) const {
    const int faces = isPanorama_ ? 1 : 6;
    for (int face = 0; face < faces; ++face)
        for (int y = 0; y < grid.down; ++y)
            for (int x = 0; x < grid.across; ++x) {
                const double left = edge(grid, false, x), top = edge(grid, true, y);
                Grid::Tile tile{};
                tile.centre = directionAt(face, left + 0.5 * grid.step, top + 0.5 * grid.step);
                double cosine = 1;
                for (const double down : {0.0, 0.5, 1.0})  // the edges' middles too: a panorama's rows are curved
                    for (const double right : {0.0, 0.5, 1.0})
                        cosine =
                            std::min(cosine, glm::dot(tile.centre, directionAt(face, left + right * grid.step, top + down * grid.step)));
                tile.radius = std::acos(std::max(cosine, -1.0));
                tile.sine = std::sin(std::min(tile.radius, 0.5 * std::numbers::pi));
                grid.tiles.push_back(tile);
            }
    const auto fill = [&](bool isRow, int count, std::vector<NodeValues>& places, std::vector<NodeValues>& sines,
                          std::vector<NodeValues>& cosines) {
        for (int tile = 0; tile < count; ++tile) {
            NodeValues place{}, sine{}, cosine{};
            for (std::size_t i = 0; i < kNodes; ++i) {
                place[i] = edge(grid, isRow, tile) + kNodePlaces[i] * grid.step;
                sine[i] = std::sin(place[i]);
                cosine[i] = std::cos(place[i]);
            }
            places.push_back(place);
            sines.push_back(sine);
            cosines.push_back(cosine);
        }
    };
    fill(false, grid.across, grid.u, grid.sineX, grid.cosineX);
    fill(true, grid.down, grid.v, grid.sineY, grid.cosineY);
    grid.weights = std::make_shared<Grid::Weights>(grid.tiles.size());
}

/// Returns the points of the tiles along one axis, on which the source has `texels` texels.
std::vector<std::vector<PrefilteredLight::Point>> PrefilteredLight::pointsOf(const Grid& grid, bool isRow, int texels) const {
    const int tiles = isRow ? grid.down : grid.across;
    const double begin = edge(grid, isRow, 0), texel = (edge(grid, isRow, tiles) - begin) / texels;
    std::vector<std::vector<Point>> all(static_cast<std::size_t>(tiles));
    for (int tile = 0; tile < tiles; ++tile) {
        const double low = static_cast<double>(tile) * texels / tiles, high = static_cast<double>(tile + 1) * texels / tiles;
        for (int index = static_cast<int>(low); index < std::min(std::ceil(high), static_cast<double>(texels)); ++index) {
            const double from = std::max<double>(low, index), to = std::min<double>(high, index + 1), share = (to - from) / (high - low);
            if (!(share > 1e-9)) continue;
            for (const GaussPoint& point : gaussRule(share <= 1.0 / 32 ? 1 : share <= 1.0 / 8 ? 2 : share <= 0.5 ? 3 : 5)) {
                const double at = from + point.place * (to - from), place = begin + at * texel;
                all[static_cast<std::size_t>(tile)].push_back(
                    {index, place, point.weight * (to - from) * texel, std::sin(place), lagrangeAt((at - low) / (high - low))});
            }
        }
    }
    return all;
}

/// Integrates the source times the polynomials of the finest grid.
void PrefilteredLight::integrate(Grid& grid) const {
    const auto texels = environment_.texels.view();
    const std::vector<std::vector<Point>> columnPoints = pointsOf(grid, false, texels.width),
                                          rowPoints = pointsOf(grid, true, isPanorama_ ? texels.height : texels.width);
    const int faces = isPanorama_ ? 1 : 6;
    std::size_t tile = 0;
    for (int face = 0; face < faces; ++face)
        for (const std::vector<Point>& rows : rowPoints)
            for (const std::vector<Point>& columns : columnPoints) {
                std::array<std::array<double, kTileNodes>, 4> sums{};
                std::array<NodeValues, 4> line{};
                int lineRow = -1;
                for (const Point& row : rows) {
                    // The rows of a panorama's texel differ by their solid angle alone.
                    if (!isPanorama_ || row.texel != lineRow) {
                        lineRow = row.texel;
                        line = {};
                        const glm::vec3* const source = texels.row(face * texels.width + row.texel);
                        for (const Point& column : columns) {
                            double solidAngle = column.weight;
                            if (!isPanorama_) {
                                const double inverse = 1 / std::sqrt(1 + column.place * column.place + row.place * row.place);
                                solidAngle *= inverse * inverse * inverse;
                            }
                            const glm::dvec3 light = solidAngle / brightest_ * glm::dvec3(source[column.texel]);
                            for (std::size_t i = 0; i < kNodes; ++i) {
                                line[0][i] += solidAngle * column.polynomial[i];
                                line[1][i] += light.x * column.polynomial[i];
                                line[2][i] += light.y * column.polynomial[i];
                                line[3][i] += light.z * column.polynomial[i];
                            }
                        }
                    }
                    const double weight = isPanorama_ ? row.weight * row.sine : row.weight;
                    for (std::size_t plane = 0; plane < 4; ++plane)
                        for (std::size_t y = 0; y < kNodes; ++y)
                            for (std::size_t x = 0; x < kNodes; ++x)
                                sums[plane][y * kNodes + x] += weight * row.polynomial[y] * line[plane][x];
                }
                for (std::size_t plane = 0; plane < 4; ++plane)
                    for (std::size_t i = 0; i < kTileNodes; ++i)
                        (*grid.weights)[tile][plane * kTileNodes + i] = static_cast<float>(sums[plane][i]);
                ++tile;
            }
}

/// Sets the weights of a grid to those of the grid of half its tiles' size.
void PrefilteredLight::join(const Grid& fine, Grid& coarse) const {
    std::array<std::array<NodeValues, kNodes>, 2> halves{};  // [half][node of the child][node of the parent]
    for (std::size_t half = 0; half < 2; ++half)
        for (std::size_t i = 0; i < kNodes; ++i) halves[half][i] = lagrangeAt(0.5 * (static_cast<double>(half) + kNodePlaces[i]));
    const int faces = isPanorama_ ? 1 : 6;
    for (int face = 0; face < faces; ++face)
        for (int y = 0; y < coarse.down; ++y)
            for (int x = 0; x < coarse.across; ++x) {
                std::array<double, 4 * kTileNodes> sums{};
                for (int child = 0; child < 4; ++child) {
                    const auto right = static_cast<std::size_t>(child % 2), below = static_cast<std::size_t>(child / 2);
                    const auto& weights = (*fine.weights)[indexOf(fine, face, 2 * x + child % 2, 2 * y + child / 2)];
                    for (std::size_t plane = 0; plane < 4; ++plane)
                        for (std::size_t row = 0; row < kNodes; ++row) {
                            NodeValues line{};
                            for (std::size_t column = 0; column < kNodes; ++column)
                                for (std::size_t i = 0; i < kNodes; ++i)
                                    line[i] +=
                                        static_cast<double>(weights[plane * kTileNodes + row * kNodes + column]) * halves[right][column][i];
                            for (std::size_t j = 0; j < kNodes; ++j)
                                for (std::size_t i = 0; i < kNodes; ++i)
                                    sums[plane * kTileNodes + j * kNodes + i] += halves[below][row][j] * line[i];
                        }
                }
                auto& out = (*coarse.weights)[indexOf(coarse, face, x, y)];
                std::ranges::transform(sums, out.begin(), [](double sum) { return static_cast<float>(sum); });
            }
}

std::size_t PrefilteredLight::indexOf(const Grid& grid, int face, int x, int y) {
    return static_cast<std::size_t>((face * grid.down + y) * grid.across + x);
}

/// Adds a tile by its nodes.
template <NormalDistribution kLobe>
void PrefilteredLight::addNodes(const Grid& grid, const TileIndex& at, const glm::dvec3& direction, Sums& sums) const {
    const auto column = static_cast<std::size_t>(at.x), row = static_cast<std::size_t>(at.y);
    std::array<double, kTileNodes> kernel;
    const double squaredM = m_ * m_;
    if (isPanorama_) {
        NodeValues along{};
        for (std::size_t x = 0; x < kNodes; ++x) along[x] = direction.x * grid.sineX[column][x] - direction.z * grid.cosineX[column][x];
        for (std::size_t y = 0; y < kNodes; ++y)
            for (std::size_t x = 0; x < kNodes; ++x)
                kernel[y * kNodes + x] = grid.sineY[row][y] * along[x] + grid.cosineY[row][y] * direction.y;
    } else {
        const FaceAxes& axes = kFaceAxes[at.face];
        const double major = glm::dot(direction, axes.major), right = glm::dot(direction, axes.right),
                     down = glm::dot(direction, axes.down);
        const NodeValues &u = grid.u[column], &v = grid.v[row];
        for (std::size_t y = 0; y < kNodes; ++y)
            for (std::size_t x = 0; x < kNodes; ++x)
                kernel[y * kNodes + x] = (major + right * u[x] + down * v[y]) / std::sqrt(1 + u[x] * u[x] + v[y] * v[y]);
    }
    for (double& value : kernel) value = kernelShape<kLobe>(value, squaredM);
    const float* const weights = (*grid.weights)[indexOf(grid, at.face, at.x, at.y)].data();
    for (std::size_t plane = 0; plane < 4; ++plane)
        for (std::size_t y = 0; y < kNodes; ++y)
            for (std::size_t x = 0; x < kNodes; ++x)
                sums.columns[plane][x] += kernel[y * kNodes + x] * static_cast<double>(weights[(plane * kNodes + y) * kNodes + x]);
}

template <NormalDistribution kLobe>
void PrefilteredLight::visit(std::size_t level, const TileIndex& at, const glm::dvec3& direction, Sums& sums) const {
    const Grid& grid = grids_[level];
    const Grid::Tile& tile = grid.tiles[indexOf(grid, at.face, at.x, at.y)];
    const double cosine = glm::dot(tile.centre, direction);
    if (cosine < tile.outside) return;
    const bool isOnKink = grid.isKinked && std::abs(cosine) < tile.sine;
    if (level == 0 || (!isOnKink && cosine <= tile.acceptable)) return addNodes<kLobe>(grid, at, direction, sums);
    for (int child = 0; child < 4; ++child) visit<kLobe>(level - 1, {at.face, 2 * at.x + child % 2, 2 * at.y + child / 2}, direction, sums);
}

template <NormalDistribution kLobe>
glm::dvec3 PrefilteredLight::sum(const glm::dvec3& direction) const {
    const Grid& coarsest = grids_.back();
    Sums sums;
    for (int face = 0; face < (isPanorama_ ? 1 : 6); ++face)
        for (int y = 0; y < coarsest.down; ++y)
            for (int x = 0; x < coarsest.across; ++x) visit<kLobe>(grids_.size() - 1, {face, x, y}, direction, sums);
    std::array<double, 4> totals{};
    for (std::size_t plane = 0; plane < 4; ++plane)
        for (const double column : sums.columns[plane]) totals[plane] += column;
    if (!(totals[0] > 0)) return glm::dvec3(0);
    return brightest_ * glm::max(glm::dvec3(totals[1], totals[2], totals[3]) / totals[0], glm::dvec3(0));
}

glm::dvec3 PrefilteredLight::towards(const glm::dvec3& direction) const {
    return lobe_ == NormalDistribution::Ggx ? sum<NormalDistribution::Ggx>(direction) : sum<NormalDistribution::Beckmann>(direction);
}

}  // namespace lightcook::verify
