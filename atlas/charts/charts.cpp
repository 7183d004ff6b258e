// Method: vertices are joined by union-find, once for each triangle and once for each quad that two triangles reach (forEachQuadRun). A
// second pass over the triangles numbers the sets in order and finds their boxes, a third marks the quads that each chart reaches.
#include "atlas/charts.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/common.hpp>
#include <string>

#include "formats/disjoint_sets.h"
#include "formats/triangle_rows.h"

namespace lightcook::atlas {
namespace {

using formats::Corners;
using formats::DisjointSets;
using formats::TriangleMesh;

constexpr std::uint32_t kNobody = UINT32_MAX;

/// Calls visit(y, begin, end) for the quads that a triangle comes closer to than `margin` [texels].
template <class Visit>
void forEachQuadRun(const Corners& corners, const glm::ivec2& size, double margin, Visit visit) {
    const auto quadOf = [](double place, int extent) { return static_cast<int>(std::clamp(std::floor(place - 0.5), -1.0, extent - 1.0)); };
    const auto [low, high] = std::minmax({corners[0].y, corners[1].y, corners[2].y});
    for (int y = quadOf(low - margin, size.y); y <= quadOf(high + margin, size.y); ++y) {
        const formats::Spread spread = formats::spreadBetween(corners, y + 0.5 - margin, y + 1.5 + margin);
        if (spread.left <= spread.right) visit(y, quadOf(spread.left - margin, size.x), quadOf(spread.right + margin, size.x) + 1);
    }
}

/// The triangles of all meshes, numbered one after the other, and their vertices likewise.
class Triangles {
public:
    Triangles(std::span<const TriangleMesh* const> meshes, const glm::ivec2& size) : meshes_(meshes), size_(size) {
        for (const TriangleMesh* mesh : meshes) {
            firstVertex_.push_back(vertexCount_);
            vertexCount_ += static_cast<std::uint32_t>(mesh->vertexCount());
        }
    }
    std::uint32_t vertexCount() const { return vertexCount_; }
    std::uint32_t firstVertexOf(std::size_t mesh) const { return firstVertex_[mesh]; }

    /// Calls visit(mesh, triangle, numbers of the three vertices, corners) for each.
    template <class Visit>
    void forEach(Visit visit) const {
        for (std::size_t mesh = 0; mesh < meshes_.size(); ++mesh) {
            const formats::MeshAttribute& uv = *meshes_[mesh]->find("TEXCOORD_1");
            for (std::size_t triangle = 0; triangle < meshes_[mesh]->triangleCount(); ++triangle) {
                std::array<std::uint32_t, 3> vertices;
                Corners corners;
                for (std::size_t i = 0; i < 3; ++i) {
                    const std::uint32_t vertex = meshes_[mesh]->indices[3 * triangle + i];
                    vertices[i] = firstVertex_[mesh] + vertex;
                    corners[i] = glm::dvec2(uv.at(vertex)) * glm::dvec2(size_);
                }
                visit(mesh, triangle, vertices, corners);
            }
        }
    }

private:
    std::span<const TriangleMesh* const> meshes_;
    glm::ivec2 size_;
    std::uint32_t vertexCount_ = 0;
    std::vector<std::uint32_t> firstVertex_;
};

formats::Result<void> checkUvs(std::span<const TriangleMesh* const> meshes, std::span<const formats::Subject> names) {
    for (std::size_t mesh = 0; mesh < meshes.size(); ++mesh) {
        const formats::MeshAttribute* uv = meshes[mesh]->find("TEXCOORD_1");
        if (uv == nullptr)
            return formats::failure(formats::ErrorCode::WrongShape, names[mesh], "found no TEXCOORD_1, expected light-map UVs");
        for (std::size_t i = 0; i < meshes[mesh]->indices.size(); ++i) {
            const glm::dvec3 place = uv->at(meshes[mesh]->indices[i]);
            if (place.x >= 0 && place.x <= 1 && place.y >= 0 && place.y <= 1) continue;
            return formats::failure(
                formats::ErrorCode::WrongShape, names[mesh],
                fmt::format("found light-map UV ({}, {}) at triangle {}, expected numbers in [0, 1]", place.x, place.y, i / 3));
        }
    }
    return {};
}

/// Returns the sets of vertices of one chart each.
DisjointSets connect(const Triangles& triangles, const glm::ivec2& size) {
    DisjointSets sets(triangles.vertexCount());
    std::vector<std::uint32_t> owners(static_cast<std::size_t>(size.x + 1) * static_cast<std::size_t>(size.y + 1), kNobody);
    triangles.forEach([&](std::size_t, std::size_t, const std::array<std::uint32_t, 3>& vertices, const Corners& corners) {
        sets.join(vertices[0], vertices[1]);
        sets.join(vertices[0], vertices[2]);
        forEachQuadRun(corners, size, 0, [&](int y, int begin, int end) {
            for (int x = begin; x < end; ++x) {
                std::uint32_t& owner =
                    owners[static_cast<std::size_t>(y + 1) * static_cast<std::size_t>(size.x + 1) + static_cast<std::size_t>(x + 1)];
                if (owner != kNobody) sets.join(owner, vertices[0]);
                owner = vertices[0];
            }
        });
    });
    return sets;
}

}  // namespace

formats::Result<ChartSet> findCharts(std::span<const TriangleMesh* const> meshes, std::span<const formats::Subject> names, int width,
                                     int height) {
    LC_CHECK(checkUvs(meshes, names));
    const glm::ivec2 size(width, height);
    const Triangles triangles(meshes, size);
    DisjointSets sets = connect(triangles, size);

    ChartSet found;
    std::vector<std::uint32_t> chartOf(triangles.vertexCount(), ChartSet::kNoChart);
    std::vector<glm::ivec2> ends;
    triangles.forEach([&](std::size_t mesh, std::size_t triangle, const std::array<std::uint32_t, 3>& vertices, const Corners& corners) {
        std::uint32_t& chart = chartOf[sets.find(vertices[0])];
        if (chart == ChartSet::kNoChart) {
            chart = static_cast<std::uint32_t>(found.charts.size());
            found.charts.push_back({.first = size, .mesh = mesh, .triangle = triangle});
            ends.emplace_back(-1);
        }
        const std::uint32_t index = chart;
        for (const std::uint32_t vertex : vertices) chartOf[vertex] = index;
        forEachQuadRun(corners, size, kPlaceRounding, [&](int y, int begin, int end) {
            found.charts[index].first = glm::min(found.charts[index].first, glm::ivec2(begin, y));
            ends[index] = glm::max(ends[index], glm::ivec2(end, y + 1));
        });
    });
    for (std::size_t i = 0; i < found.charts.size(); ++i) {
        Chart& chart = found.charts[i];
        chart.quads = ends[i] - chart.first;
        chart.reached.assign(static_cast<std::size_t>(chart.quads.x) * static_cast<std::size_t>(chart.quads.y), 0);
    }
    triangles.forEach([&](std::size_t, std::size_t, const std::array<std::uint32_t, 3>& vertices, const Corners& corners) {
        Chart& chart = found.charts[chartOf[vertices[0]]];
        forEachQuadRun(corners, size, kPlaceRounding, [&](int y, int begin, int end) {
            const auto row = chart.reached.begin() + static_cast<std::ptrdiff_t>(y - chart.first.y) * chart.quads.x - chart.first.x;
            std::fill(row + begin, row + end, std::uint8_t{1});
        });
    });
    for (std::size_t mesh = 0; mesh < meshes.size(); ++mesh) {
        const auto first = chartOf.begin() + static_cast<std::ptrdiff_t>(triangles.firstVertexOf(mesh));
        found.ofVertex.emplace_back(first, first + static_cast<std::ptrdiff_t>(meshes[mesh]->vertexCount()));
    }
    return found;
}

}  // namespace lightcook::atlas
