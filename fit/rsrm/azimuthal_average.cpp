#include "fit/azimuthal_average.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>

#include "lighting/cube.h"
#include "lighting/sphere.h"

namespace lightcook::fit {
namespace {

using std::numbers::pi;

constexpr int kMostZones = 4096;

/// A directed arc of the circle of points whose height along `normal` is `height`, counter-clockwise around the normal, seen from the axis:
/// z = middle + reach cos t, with t from the circle's highest point. For such a circle
///   d phi   = d North + d South,   z d phi = height dt + d North - d South
/// where North and South are the angles by which the arc turns around the two poles of the axis.
class Arc {
public:
    Arc(const glm::dvec3& axis, const glm::dvec3& normal, double height, const glm::dvec3& from, const glm::dvec3& to) : height_(height) {
        const double slope = glm::dot(axis, normal);
        const glm::dvec3 level = axis - slope * normal;
        const double levelLength = glm::length(level), radius = std::sqrt(std::max(0.0, 1 - height * height));
        // If the axis is the normal, all points have the same height, and t may start anywhere.
        const glm::dvec3 highest = levelLength > 1e-12 ? level / levelLength : glm::normalize(from - height * normal);
        const glm::dvec3 side = glm::cross(normal, highest);
        middle_ = height * slope;
        reach_ = radius * levelLength;
        begin_ = std::atan2(glm::dot(from, side), glm::dot(from, highest));
        end_ = std::atan2(glm::dot(to, side), glm::dot(to, highest));
        if (end_ < begin_) end_ += 2 * pi;
        if (radius == 0) end_ = begin_;  // the side at the pole of a panorama is a point
        northSign_ = slope < height ? -1 : 1;
        southSign_ = slope + height < 0 ? -1 : 1;
        north_ = {1 - middle_ + reach_, std::abs(slope - height)};
        south_ = {std::abs(slope + height), 1 + middle_ + reach_};
    }
    /// Returns the integral of max(0, z - h) d phi along the arc.
    double above(double h) const {
        if (h <= middle_ - reach_) return integral(begin_, end_, h);
        if (h >= middle_ + reach_) return 0;
        const double half = std::acos(std::clamp((h - middle_) / reach_, -1.0, 1.0));
        return part(-half, half, h) + part(2 * pi - half, 2 * pi + half, h);
    }
    double lowest() const { return reaches(pi) ? middle_ - reach_ : std::min(at(begin_), at(end_)); }
    double highest() const { return reaches(0) || reaches(2 * pi) ? middle_ + reach_ : std::max(at(begin_), at(end_)); }

private:
    double at(double t) const { return middle_ + reach_ * std::cos(t); }
    bool reaches(double t) const { return begin_ <= t && t <= end_; }
    double part(double from, double to, double h) const {
        from = std::max(from, begin_), to = std::min(to, end_);
        return from < to ? integral(from, to, h) : 0;
    }
    double integral(double from, double to, double h) const {
        const auto turned = [](const std::array<double, 2>& stretch, double t) {
            return std::atan2(stretch[0] * std::sin(t / 2), stretch[1] * std::cos(t / 2));
        };
        const double north = northSign_ * (turned(north_, to) - turned(north_, from));
        const double south = southSign_ * (turned(south_, to) - turned(south_, from));
        return height_ * (to - from) + (1 - h) * north - (1 + h) * south;
    }

    double height_, middle_, reach_, begin_, end_, northSign_, southSign_;
    std::array<double, 2> north_, south_;
};

/// The four sides of a texel, counter-clockwise as seen from outside the sphere. Sides that run against their circle count negative.
struct Outline {
    std::array<Arc, 4> arcs;
    std::array<double, 4> signs;
    double solidAngle;
};

/// Corners and sides of the texels of either projection.
class TexelGrid {
public:
    TexelGrid(const formats::Environment& environment, const glm::dvec3& axis)
        : axis_(axis),
          isPanorama_(environment.projection == formats::Environment::Projection::Equirectangular),
          width_(environment.texels.width()),
          height_(environment.texels.height()) {}

    /// Returns the direction of a corner; in a strip, on the face that holds row y.
    glm::dvec3 corner(int x, int y, int row) const {
        if (isPanorama_) {
            const double theta = pi * y / height_, psi = 2 * pi * x / width_ - pi;
            return {std::sin(theta) * std::sin(psi), std::cos(theta), -std::sin(theta) * std::cos(psi)};
        }
        const int face = row / width_;
        return lighting::directionFromCube({face, {2.0 * x / width_ - 1, 2.0 * (y - face * width_) / width_ - 1}});
    }
    double solidAngle(int x, int y) const {
        return isPanorama_ ? lighting::equirectangularTexelSolidAngle(y, width_, height_)
                           : lighting::cubeTexelSolidAngle(x, y % width_, width_);
    }
    Outline outline(int x, int y, const std::array<glm::dvec3, 4>& c) const {
        return isPanorama_ ? panoramaOutline(x, y, c) : stripOutline(x, y, c);
    }
    std::array<int, 2> texelTowards(const glm::dvec3& direction) const {
        glm::dvec2 uv(0);
        int top = 0, rows = height_;
        if (isPanorama_) {
            uv = lighting::equirectangularFromDirection(direction);
        } else {
            const lighting::CubeCoordinate place = lighting::cubeFromDirection(direction);
            uv = 0.5 * place.uv + 0.5;
            top = place.face * width_;
            rows = width_;
        }
        return {std::clamp(static_cast<int>(uv.x * width_), 0, width_ - 1), top + std::clamp(static_cast<int>(uv.y * rows), 0, rows - 1)};
    }

private:
    // Corners: 0 (x, y), 1 (x + 1, y), 2 (x, y + 1), 3 (x + 1, y + 1). The x of a panorama runs clockwise around Y, as seen from inside;
    // the texels of a face are laid out as seen from outside.
    Outline panoramaOutline(int x, int y, const std::array<glm::dvec3, 4>& c) const {
        const auto meridian = [&](int column) {
            const double psi = 2 * pi * column / width_ - pi;
            return glm::dvec3(-std::cos(psi), 0, -std::sin(psi));  // Y x (sin psi, 0, -cos psi): from north to south
        };
        const glm::dvec3 up(0, 1, 0);
        const double top = std::cos(pi * y / height_), bottom = std::cos(pi * (y + 1) / height_);
        return {{Arc(axis_, up, top, c[1], c[0]), Arc(axis_, up, bottom, c[3], c[2]), Arc(axis_, meridian(x), 0, c[0], c[2]),
                 Arc(axis_, meridian(x + 1), 0, c[1], c[3])},
                {-1, 1, -1, 1},
                solidAngle(x, y)};
    }
    Outline stripOutline(int x, int y, const std::array<glm::dvec3, 4>& c) const {
        const auto side = [&](int from, int to) {
            const glm::dvec3 &a = c[static_cast<std::size_t>(from)], &b = c[static_cast<std::size_t>(to)];
            return Arc(axis_, glm::normalize(glm::cross(a, b)), 0, a, b);
        };
        return {{side(0, 2), side(2, 3), side(3, 1), side(1, 0)}, {1, 1, 1, 1}, solidAngle(x, y)};
    }

    glm::dvec3 axis_;
    bool isPanorama_;
    int width_, height_;
};

/// The limits of the zones, and their sums.
class Zones {
public:
    explicit Zones(int count) : areas_(static_cast<std::size_t>(count), 0.0), sums_(static_cast<std::size_t>(count), glm::dvec3(0)) {}
    int count() const { return static_cast<int>(areas_.size()); }
    double lowerEdge(int zone) const { return 1 - 2.0 * (zone + 1) / count(); }
    int of(double z) const { return std::clamp(static_cast<int>(0.5 * (1 - z) * count()), 0, count() - 1); }
    void add(int zone, double solidAngle, const glm::dvec3& radiance) {
        areas_[static_cast<std::size_t>(zone)] += solidAngle;
        sums_[static_cast<std::size_t>(zone)] += solidAngle * radiance;
        energy_ += solidAngle * glm::dot(radiance, radiance);
    }
    /// Returns true if the area of every zone is that of its definition. It is not if a pole lies exactly on a side of a texel.
    bool isWhole() const {
        const double expected = 4 * pi / count();
        return std::ranges::all_of(areas_, [&](double area) { return std::abs(area - expected) <= 1e-6 * expected + 1e-9; });
    }
    AzimuthalAverage average() const {
        AzimuthalAverage result;
        double kept = 0;
        for (std::size_t zone = 0; zone < areas_.size(); ++zone) {
            const glm::dvec3 mean = areas_[zone] > 0 ? sums_[zone] / areas_[zone] : glm::dvec3(0);
            result.gradient.emplace_back(mean);
            kept += areas_[zone] * glm::dot(mean, mean);
        }
        if (energy_ > 0) result.asymmetricEnergy = std::clamp(1 - kept / energy_, 0.0, 1.0);
        return result;
    }

private:
    std::vector<double> areas_;
    std::vector<glm::dvec3> sums_;
    double energy_ = 0;
};

struct SourceTexel {
    int x, y;
    std::array<glm::dvec3, 4> corners;
    bool holdsNorth, holdsSouth;  ///< the poles of the axis
    glm::dvec3 radiance;
};

/// Distributes a texel to the zones by its solid angle in each.
void addTexel(const TexelGrid& grid, const SourceTexel& texel, const glm::dvec3& axis, Zones& zones) {
    double low = 1, high = -1, longest = 0;
    for (std::size_t i = 0; i < 4; ++i) {
        const double z = glm::dot(axis, texel.corners[i]);
        low = std::min(low, z), high = std::max(high, z);
        const glm::dvec3 side = texel.corners[i] - texel.corners[i == 0 ? 3 : 0];
        longest = std::max(longest, glm::dot(side, side));
    }
    // Early exit for most texels. A side bulges by at most 1/8 of its squared length, on a small circle by twice that.
    const bool isSmall = longest < 0.05 && !texel.holdsNorth && !texel.holdsSouth;
    const int first = zones.of(high + longest), last = zones.of(low - longest);
    if (isSmall && first == last) return zones.add(first, grid.solidAngle(texel.x, texel.y), texel.radiance);

    const Outline outline = grid.outline(texel.x, texel.y, texel.corners);
    for (const Arc& arc : outline.arcs) low = std::min(low, arc.lowest()), high = std::max(high, arc.highest());
    const int from = texel.holdsNorth ? 0 : zones.of(high), to = texel.holdsSouth ? zones.count() - 1 : zones.of(low);
    double before = 0;
    for (int zone = from; zone <= to; ++zone) {
        double above = outline.solidAngle;
        if (zone < to) {
            const double edge = zones.lowerEdge(zone);
            above = texel.holdsNorth ? 2 * pi * (1 - edge) : 0;
            for (std::size_t i = 0; i < 4; ++i) above -= outline.signs[i] * outline.arcs[i].above(edge);
            above = std::clamp(above, before, outline.solidAngle);
        }
        zones.add(zone, above - before, texel.radiance);
        before = above;
    }
}

Zones gather(const formats::Environment& environment, const glm::dvec3& axis, int zoneCount) {
    const TexelGrid grid(environment, axis);
    const formats::Image<glm::vec3>& texels = environment.texels;
    const std::array<int, 2> north = grid.texelTowards(axis), south = grid.texelTowards(-axis);
    Zones zones(zoneCount);
    const auto cornersOfRow = [&](int y, int row) {
        std::vector<glm::dvec3> corners;
        for (int x = 0; x <= texels.width(); ++x) corners.push_back(grid.corner(x, y, row));
        return corners;
    };
    for (int y = 0; y < texels.height(); ++y) {
        const std::vector<glm::dvec3> upper = cornersOfRow(y, y), lower = cornersOfRow(y + 1, y);
        for (int x = 0; x < texels.width(); ++x) {
            const auto column = static_cast<std::size_t>(x);
            const std::array<int, 2> at = {x, y};
            const std::array<glm::dvec3, 4> corners = {upper[column], upper[column + 1], lower[column], lower[column + 1]};
            addTexel(grid, {x, y, corners, at == north, at == south, glm::dvec3(texels.at(x, y))}, axis, zones);
        }
    }
    return zones;
}

}  // namespace

formats::Result<void> checkAzimuthalAverage(const glm::dvec3& axis, int zoneCount) {
    using formats::ErrorCode;
    const double length = glm::length(axis);
    if (!(length > 0) || !std::isfinite(length))
        return formats::failure(ErrorCode::InvalidRequest, "axis of a gradient",
                                fmt::format("found ({}, {}, {}), expected a finite direction other than zero", axis.x, axis.y, axis.z));
    if (zoneCount < 1 || zoneCount > kMostZones)
        return formats::failure(ErrorCode::InvalidRequest, "zones of a gradient",
                                fmt::format("found {}, expected 1 to {}", zoneCount, kMostZones));
    return {};
}

AzimuthalAverage averageAroundAxis(const formats::Environment& environment, const glm::dvec3& axis, int zoneCount) {
    assert(checkAzimuthalAverage(axis, zoneCount).has_value());
    // No side may pass through a pole of the axis, so turn the axis by 1e-8. If the areas of the zones show that one still does, turn it
    // farther.
    const glm::dvec3 unit = glm::normalize(axis);
    for (double off = 1e-8;; off *= 3) {
        const glm::dvec3 turned = glm::normalize(unit + off * glm::dvec3(0.4142135, -0.2679492, 0.6180340));
        const Zones zones = gather(environment, turned, zoneCount);
        if (zones.isWhole() || off > 1e-4) return zones.average();
    }
}

}  // namespace lightcook::fit
