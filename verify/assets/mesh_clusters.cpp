#include "verify/mesh.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

namespace lightcook::verify {
namespace {

using Corners = std::array<glm::dvec2, 3>;  ///< [texels]

double cross(const glm::dvec2& a, const glm::dvec2& b) {
    return a.x * b.y - a.y * b.x;
}

/// Returns the distance of a point from the nearest edge, negative outside. Always negative for a triangle without area.
double depthInside(const Corners& corners, const glm::dvec2& point) {
    double shallowest = HUGE_VAL;
    for (std::size_t i = 0; i < 3; ++i) {
        const glm::dvec2 edge = corners[(i + 1) % 3] - corners[i];
        const double turn = cross(edge, corners[(i + 2) % 3] - corners[i]), length = glm::length(edge);
        if (turn == 0 || length == 0) return -1;
        shallowest = std::min(shallowest, (turn < 0 ? -1 : 1) * cross(edge, point - corners[i]) / length);
    }
    return shallowest;
}

/// Returns true if a triangle overlaps the square with this half side around a point (separating axis test).
bool meetsSquare(const Corners& corners, const glm::dvec2& centre, double half) {
    std::array<glm::dvec2, 5> axes = {glm::dvec2(1, 0), glm::dvec2(0, 1)};
    for (std::size_t i = 0; i < 3; ++i) {
        const glm::dvec2 edge = corners[(i + 1) % 3] - corners[i];
        axes[2 + i] = {-edge.y, edge.x};
    }
    for (const glm::dvec2& axis : axes) {
        if (axis == glm::dvec2(0)) continue;
        const auto along = [&](std::size_t i) { return glm::dot(axis, corners[i] - centre); };
        const auto [low, high] = std::minmax({along(0), along(1), along(2)});
        const double reach = half * (std::abs(axis.x) + std::abs(axis.y));
        if (low > reach || high < -reach) return false;
    }
    return true;
}

int texelOf(double place, int size) {
    return static_cast<int>(std::clamp(std::floor(place), 0.0, size - 1.0));
}

/// Returns the first texel of another cluster that a triangle reads.
std::optional<glm::ivec2> strangerIn(const Corners& corners, int cluster, const formats::ClusterMap& map, const CoveredTexels& covered,
                                     double inset) {
    const auto [left, right] = std::minmax({corners[0].x, corners[1].x, corners[2].x});
    const auto [top, bottom] = std::minmax({corners[0].y, corners[1].y, corners[2].y});
    for (int y = texelOf(top - 1, map.height); y <= texelOf(bottom + 1, map.height); ++y)
        for (int x = texelOf(left - 1, map.width); x <= texelOf(right + 1, map.width); ++x) {
            if (map.at(x, y) == cluster) continue;
            const glm::dvec2 centre(x + 0.5, y + 0.5);
            if (depthInside(corners, centre) > inset || (covered.at(x, y) && meetsSquare(corners, centre, 1 - inset)))
                return glm::ivec2(x, y);
        }
    return std::nullopt;
}

}  // namespace

CoveredTexels::CoveredTexels(int width, int height) : width_(width), height_(height), bits_(byteOf(0, height)) {}

void CoveredTexels::add(const formats::LightMapStrip& strip, int firstRow, int rowCount) {
    for (int y = firstRow; y < firstRow + rowCount; ++y)
        for (int x = 0; x < width_; ++x)
            if (strip.covered.at(x, y - strip.firstRow) != 0) bits_[byteOf(x, y)] |= static_cast<std::uint8_t>(1u << (x % 8));
}

std::optional<std::string> clusterMistake(const formats::TriangleMesh& mesh, const formats::ClusterMap& map, const CoveredTexels& covered,
                                          double inset) {
    assert(covered.width() == map.width && covered.height() == map.height);
    const formats::MeshAttribute* uv = mesh.find("TEXCOORD_1");
    const formats::MeshAttribute* cluster = mesh.find(formats::kBasisAttribute);
    if (uv == nullptr || cluster == nullptr || cluster->componentCount != 1)
        return std::string("found no scalar ") + formats::kBasisAttribute + " beside TEXCOORD_1, expected both";
    for (std::size_t triangle = 0; triangle < mesh.triangleCount(); ++triangle) {
        Corners corners;
        const std::uint32_t* vertex = &mesh.indices[3 * triangle];
        const auto clusterAt = [&](std::size_t corner) { return static_cast<int>(cluster->at(vertex[corner]).x); };
        const int expected = clusterAt(0);
        const std::string place = " in triangle " + std::to_string(triangle);
        for (std::size_t i = 0; i < 3; ++i) {
            const glm::dvec3 value = uv->at(vertex[i]);
            corners[i] = {value.x * map.width, value.y * map.height};
            if (clusterAt(i) != expected)
                return "found vertices of clusters " + std::to_string(expected) + " and " + std::to_string(clusterAt(i)) + place +
                       ", expected one";
        }
        if (const auto texel = strangerIn(corners, expected, map, covered, inset))
            return "found cluster " + std::to_string(expected) + place + ", expected " + std::to_string(map.at(texel->x, texel->y)) +
                   " as the light map has at texel (" + std::to_string(texel->x) + ", " + std::to_string(texel->y) + ")";
    }
    return std::nullopt;
}

}  // namespace lightcook::verify
