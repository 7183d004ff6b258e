#include "pipeline/assets/light_map/small_charts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <limits>
#include <utility>

#include "pipeline/assets/light_map/checked_light_map.h"

namespace lightcook::pipeline {
namespace {

using verify::SurfaceTriangle;

double crossOf(const glm::dvec2& a, const glm::dvec2& b) {
    return a.x * b.y - a.y * b.x;
}

/// Returns the area of a triangle in the map [UV units squared].
double uvAreaOf(const SurfaceTriangle& triangle) {
    return std::abs(crossOf(triangle.uv[1] - triangle.uv[0], triangle.uv[2] - triangle.uv[0])) / 2;
}

/// Returns the squared distance from a place to a triangle in the map [texels squared]; 0 inside.
double squaredDistance(const SurfaceTriangle& triangle, const glm::dvec2& size, const glm::dvec2& place) {
    std::array<glm::dvec2, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) corners[k] = triangle.uv[k] * size - 0.5 - place;
    double nearest = std::numeric_limits<double>::infinity();
    bool isLeft = true, isRight = true;  // of all edges
    for (std::size_t k = 0; k < 3; ++k) {
        const glm::dvec2 &from = corners[k], edge = corners[(k + 1) % 3] - from;
        const double squared = glm::dot(edge, edge);
        const double along = squared > 0 ? glm::clamp(-glm::dot(from, edge) / squared, 0.0, 1.0) : 0;
        const glm::dvec2 away = from + along * edge;
        nearest = std::min(nearest, glm::dot(away, away));
        const double side = crossOf(edge, -from);
        isLeft = isLeft && side >= 0;
        isRight = isRight && side <= 0;
    }
    return uvAreaOf(triangle) > 0 && (isLeft || isRight) ? 0 : nearest;
}

/// A vertex as charts share it: position and light-map UV, without the last digits.
using VertexKey = std::pair<std::array<float, 3>, std::array<std::int64_t, 2>>;
VertexKey keyOf(const SurfaceTriangle& triangle, std::size_t corner) {
    constexpr double kSteps = 65536;
    const glm::dvec3& position = triangle.position[corner];
    return {{static_cast<float>(position.x), static_cast<float>(position.y), static_cast<float>(position.z)},
            {std::llround(triangle.uv[corner].x * kSteps), std::llround(triangle.uv[corner].y * kSteps)}};
}

/// Vertices with the triangles that have them, in order.
using Vertices = std::vector<std::pair<VertexKey, std::size_t>>;
Vertices verticesOf(std::span<const SurfaceTriangle> triangles) {
    Vertices vertices;
    vertices.reserve(3 * triangles.size());
    for (std::size_t i = 0; i < triangles.size(); ++i)
        for (std::size_t k = 0; k < 3; ++k) vertices.emplace_back(keyOf(triangles[i], k), i);
    std::ranges::sort(vertices);
    return vertices;
}

std::optional<double> fewTexelsAt(std::span<const SurfaceTriangle> triangles, const Vertices& vertices, const glm::dvec2& size,
                                  const glm::dvec2& place) {
    std::size_t first = triangles.size();
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < triangles.size(); ++i)
        if (const double distance = squaredDistance(triangles[i], size, place); distance < least) {
            least = distance;
            first = i;
        }
    if (first == triangles.size()) return std::nullopt;
    // From triangle to triangle over shared vertices, until the chart is known to be large.
    std::vector<bool> isKnown(triangles.size(), false);
    std::vector<std::size_t> chart = {first};
    isKnown[first] = true;
    double area = 0;
    for (std::size_t next = 0; next < chart.size(); ++next) {
        area += uvAreaOf(triangles[chart[next]]) * size.x * size.y;
        if (area >= kFewTexels) return std::nullopt;
        for (std::size_t k = 0; k < 3; ++k) {
            const VertexKey key = keyOf(triangles[chart[next]], k);
            for (auto at = std::ranges::lower_bound(vertices, std::pair(key, std::size_t{0})); at != vertices.end() && at->first == key;
                 ++at)
                if (!isKnown[at->second]) {
                    isKnown[at->second] = true;
                    chart.push_back(at->second);
                }
        }
    }
    return area;
}

std::string adviceOn(double texels) {
    const long long count = std::max(1LL, std::llround(texels));
    return fmt::format(
        "The chart of the largest error has {} texel{}, and filters read those beside it: no layout lowers this error much. "
        "Give the chart more texels in the bake.",
        count, count == 1 ? "" : "s");
}

}  // namespace

std::optional<double> fewTexelsAt(std::span<const SurfaceTriangle> triangles, const glm::dvec2& size, const glm::dvec2& place) {
    return fewTexelsAt(triangles, verticesOf(triangles), size, place);
}

std::vector<FewTexels> fewTexelsOf(const verify::StageError& stage, std::span<const SurfaceTriangle> triangles, const glm::dvec2& size) {
    std::vector<FewTexels> few;
    const Vertices vertices = verticesOf(triangles);
    for (const auto& [shading, figures] : {std::pair("diffuse", &stage.diffuse), std::pair("specular", &stage.specular)}) {
        if (!figures->visible || !figures->visible->maxAt.isKnown()) continue;
        const verify::VisiblePlace& at = figures->visible->maxAt;
        if (const auto texels = fewTexelsAt(triangles, vertices, size, {at.x, at.y})) few.push_back({shading, *texels, adviceOn(*texels)});
    }
    return few;
}

/// The triangles are those of the cooked mesh: where charts were packed, the places of the last stage lie in the bake as it was before.
formats::Result<void> checkSmallCharts(CheckedLightMap& map) {
    map.result.charts->few = fewTexelsOf(map.total(), map.triangles, {map.bake.width(), map.bake.height()});
    return {};
}

}  // namespace lightcook::pipeline
