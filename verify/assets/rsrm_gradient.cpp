#include "verify/rsrm.h"

#include <algorithm>
#include <cmath>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <numbers>

#include "lighting/cube.h"

namespace lightcook::verify {
namespace {

using std::numbers::pi;

/// Approximate number of lines over the height of a panorama or a face, and for each zone; and the smallest number for each row of texels.
constexpr int kLines = 4096, kLinesPerZone = 8, kLeastLinesPerRow = 4;

struct Sums {
    explicit Sums(int zoneCount) : areas(static_cast<std::size_t>(zoneCount), 0.0), light(static_cast<std::size_t>(zoneCount)) {}
    int zoneOf(double z) const {
        const int count = static_cast<int>(areas.size());
        return std::clamp(static_cast<int>(0.5 * (1 - z) * count), 0, count - 1);
    }
    double upperEdge(int zone) const { return 1 - 2.0 * zone / static_cast<double>(areas.size()); }
    void add(int zone, double area, const glm::dvec3& radiance) {
        areas[static_cast<std::size_t>(zone)] += area;
        light[static_cast<std::size_t>(zone)] += area * radiance;
        energy += area * glm::dot(radiance, radiance);
    }
    glm::dvec3 mean(std::size_t zone) const { return areas[zone] > 0 ? light[zone] / areas[zone] : glm::dvec3(0); }

    std::vector<double> areas;
    std::vector<glm::dvec3> light;
    double energy = 0;
};

/// A line on the sphere with height z(t) = middle + reach cos(t - peak). The area of a piece is the difference of `measure` at its ends.
struct Line {
    double middle, reach, peak;
    double height(double t) const { return middle + reach * std::cos(t - peak); }
};

/// Adds the piece [from, to] of a line, on which z is monotone, to the zones that it crosses.
template <class Measure>
void addMonotone(const Line& line, double from, double to, const glm::dvec3& radiance, const Measure& measure, Sums& sums) {
    int zone = sums.zoneOf(line.height(from));
    const int last = sums.zoneOf(line.height(to)), step = last > zone ? 1 : -1;
    double begin = measure(from);
    // z rises before the peak (side -1) and falls after it (side 1).
    const double turn = 2 * pi * std::round((0.5 * (from + to) - line.peak) / (2 * pi)),
                 side = 0.5 * (from + to) - line.peak < turn ? -1 : 1;
    for (; zone != last; zone += step) {
        const double edge = sums.upperEdge(step > 0 ? zone + 1 : zone);
        const double t = line.peak + turn + side * std::acos(std::clamp((edge - line.middle) / line.reach, -1.0, 1.0));
        const double end = measure(std::clamp(t, from, to));
        sums.add(zone, end - begin, radiance);
        begin = end;
    }
    sums.add(zone, measure(to) - begin, radiance);
}

/// Adds the piece of a line within a texel, cut at the line's highest and lowest point.
template <class Measure>
void addPiece(const Line& line, double from, double to, const glm::dvec3& radiance, const Measure& measure, Sums& sums) {
    const double firstTurn = std::ceil((from - line.peak) / pi);
    const double cut = line.peak + firstTurn * pi;
    if (cut > from && cut < to) {
        addMonotone(line, from, cut, radiance, measure, sums);
        from = cut;
        if (cut + pi < to) {  // the piece spans more than half a turn
            addMonotone(line, from, cut + pi, radiance, measure, sums);
            from = cut + pi;
        }
    }
    addMonotone(line, from, to, radiance, measure, sums);
}

/// The height of a line within a row of texels, and the width of the slice that it samples.
struct Slice {
    double at, width;
};
/// Cuts the row [low, high] into equal slices, and at the zones' edges if zones run along the row.
std::vector<Slice> slicesOf(double low, double high, int count, const std::vector<double>& edges) {
    std::vector<double> cuts;
    for (int i = 0; i <= count; ++i) cuts.push_back(low + (high - low) * i / count);
    const auto first = std::upper_bound(edges.begin(), edges.end(), low);
    for (auto edge = first; edge != edges.end() && *edge < high; ++edge) cuts.push_back(*edge);
    if (first != edges.end()) std::sort(cuts.begin(), cuts.end());
    std::vector<Slice> slices;
    for (std::size_t i = 0; i + 1 < cuts.size(); ++i) slices.push_back({0.5 * (cuts[i] + cuts[i + 1]), cuts[i + 1] - cuts[i]});
    return slices;
}

Sums alongParallels(const formats::Image<glm::vec3>& texels, const glm::dvec3& axis, int zoneCount, int linesPerRow) {
    Sums sums(zoneCount);
    const int width = texels.width(), height = texels.height();
    std::vector<double> edges;
    if (std::abs(axis.y) > 0.999)
        for (int zone = zoneCount - 1; zone > 0; --zone)
            edges.push_back(sums.upperEdge(zone));  // symmetric, so valid for both directions of the axis
    const double peak = std::atan2(axis.x, -axis.z), level = glm::length(glm::dvec2(axis.x, axis.z));
    for (int y = 0; y < height; ++y)
        for (const Slice& slice : slicesOf(std::cos(pi * (y + 1) / height), std::cos(pi * y / height), linesPerRow, edges)) {
            const Line line{slice.at * axis.y, std::sqrt(std::max(0.0, 1 - slice.at * slice.at)) * level, peak};
            const auto measure = [&](double t) { return slice.width * t; };
            for (int x = 0; x < width; ++x)
                addPiece(line, 2 * pi * x / width - pi, 2 * pi * (x + 1) / width - pi, glm::dvec3(texels.at(x, y)), measure, sums);
        }
    return sums;
}

Sums alongFaceRows(const formats::Image<glm::vec3>& texels, const glm::dvec3& axis, int zoneCount, int linesPerRow) {
    Sums sums(zoneCount);
    const int size = texels.width();
    for (int row = 0; row < texels.height(); ++row) {
        const int face = row / size;
        const double top = 2.0 * (row % size) / size - 1;
        for (const Slice& slice : slicesOf(top, top + 2.0 / size, linesPerRow, {})) {
            // A row of a face is part of a great circle through the row's middle, along u.
            const glm::dvec3 middle = lighting::directionFromCube({face, {0, slice.at}});
            const glm::dvec3 along = lighting::directionFromCube({face, {1, slice.at}});
            const glm::dvec3 side = glm::normalize(along - glm::dot(along, middle) * middle);
            const double far = std::sqrt(1 + slice.at * slice.at);  // distance of the middle from the cube's centre; u = far tan t
            const double toMiddle = glm::dot(axis, middle), toSide = glm::dot(axis, side);
            const Line line{0, glm::length(glm::dvec2(toMiddle, toSide)), std::atan2(toSide, toMiddle)};
            // The integral of du / (far^2 + u^2)^(3/2).
            const auto measure = [&](double t) { return slice.width * std::sin(t) / (far * far); };
            double from = std::atan(-1 / far);
            for (int x = 0; x < size; ++x) {
                const double to = std::atan((2.0 * (x + 1) / size - 1) / far);
                addPiece(line, from, to, glm::dvec3(texels.at(x, row)), measure, sums);
                from = to;
            }
        }
    }
    return sums;
}

Sums gather(const formats::Environment& environment, const glm::dvec3& axis, int zoneCount, int linesPerRow) {
    return environment.projection == formats::Environment::Projection::Equirectangular
               ? alongParallels(environment.texels, axis, zoneCount, linesPerRow)
               : alongFaceRows(environment.texels, axis, zoneCount, linesPerRow);
}

}  // namespace

AxialGradient axialGradient(const formats::Environment& environment, const glm::dvec3& axis, int zoneCount) {
    const glm::dvec3 unit = glm::normalize(axis);
    const int rows = environment.projection == formats::Environment::Projection::Equirectangular ? environment.texels.height()
                                                                                                 : environment.texels.width();
    const int perRow = std::max(kLeastLinesPerRow, std::max(kLines, kLinesPerZone * zoneCount) / rows);
    const Sums fine = gather(environment, unit, zoneCount, perRow), coarse = gather(environment, unit, zoneCount, perRow / 2);
    AxialGradient result;
    double kept = 0;
    for (std::size_t zone = 0; zone < fine.areas.size(); ++zone) {
        const glm::dvec3 mean = fine.mean(zone);
        result.gradient.emplace_back(mean);
        result.uncertainty = glm::max(result.uncertainty, 2.0 * glm::abs(mean - coarse.mean(zone)));
        kept += fine.areas[zone] * glm::dot(mean, mean);
    }
    if (fine.energy > 0) result.asymmetricEnergy = std::clamp(1 - kept / fine.energy, 0.0, 1.0);
    return result;
}

}  // namespace lightcook::verify
