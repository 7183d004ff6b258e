#include "formats/gltf/triangle_mesh.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <glm/geometric.hpp>
#include <limits>
#include <map>
#include <tuple>
#include <type_traits>

namespace lightcook::formats {
namespace {

template <class Component>
double componentAt(const std::byte* bytes, bool isNormalized) {
    Component value{};
    std::memcpy(&value, bytes, sizeof value);
    const double number = static_cast<double>(value);
    if constexpr (std::is_integral_v<Component>) {
        if (isNormalized) return std::max(number / static_cast<double>(std::numeric_limits<Component>::max()), -1.0);
    }
    return number;
}

/// Calls visit(zero) with a zero of the type of a component, and returns what it returns; 0 for a type of no known number.
template <class Visit>
auto visitType(ComponentType type, Visit visit) {
    switch (type) {
        case ComponentType::Int8:
            return visit(std::int8_t{});
        case ComponentType::Uint8:
            return visit(std::uint8_t{});
        case ComponentType::Int16:
            return visit(std::int16_t{});
        case ComponentType::Uint16:
            return visit(std::uint16_t{});
        case ComponentType::Uint32:
            return visit(std::uint32_t{});
        case ComponentType::Float32:
            return visit(float{});
    }
    return decltype(visit(float{}))();
}

/// Returns the place of one component of a vertex in the values of an attribute [bytes].
std::size_t offsetOf(const MeshAttribute& attribute, std::size_t vertex, int index) {
    return vertex * attribute.bytesPerVertex() + static_cast<std::size_t>(index) * componentBytes(attribute.componentType);
}

/// The corners of one triangle, for comparison.
struct Corners {
    std::array<glm::dvec3, 3> position, normal, uv;
    glm::dvec3 centroid() const { return (position[0] + position[1] + position[2]) / 3.0; }
};

enum class Degenerate { Drop, Keep };

std::vector<Corners> cornersOf(const TriangleMesh& mesh, bool compareNormals, bool compareUvs, Degenerate degenerate) {
    const MeshAttribute* position = mesh.find("POSITION");
    const MeshAttribute* normal = compareNormals ? mesh.find("NORMAL") : nullptr;
    const MeshAttribute* uv = compareUvs ? mesh.find("TEXCOORD_1") : nullptr;
    const auto samePosition = [&](std::uint32_t a, std::uint32_t b) {
        const std::size_t bytes = position->bytesPerVertex();
        return std::memcmp(position->values.data() + a * bytes, position->values.data() + b * bytes, bytes) == 0;
    };
    std::vector<Corners> triangles;
    for (std::size_t first = 0; first + 2 < mesh.indices.size(); first += 3) {
        const std::uint32_t* corner = &mesh.indices[first];
        const bool isDegenerate =
            samePosition(corner[0], corner[1]) || samePosition(corner[1], corner[2]) || samePosition(corner[2], corner[0]);
        if (isDegenerate && degenerate == Degenerate::Drop) continue;
        Corners& triangle = triangles.emplace_back();
        for (std::size_t i = 0; i < 3; ++i) {
            triangle.position[i] = position->at(corner[i]);
            triangle.normal[i] = normal != nullptr ? normal->at(corner[i]) : glm::dvec3(0);
            triangle.uv[i] = uv != nullptr ? uv->at(corner[i]) : glm::dvec3(0);
        }
    }
    return triangles;
}

double angleBetween(const glm::dvec3& a, const glm::dvec3& b) {
    if (glm::length(a) < 1e-12 || glm::length(b) < 1e-12) return 0;  // no direction to compare
    return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

/// The differences of two triangles when corner i of one meets corner i + turn of the other.
TriangleMatch difference(const Corners& a, const Corners& b, std::size_t turn) {
    TriangleMatch worst;
    for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t j = (i + turn) % 3;
        worst.position = std::max(worst.position, glm::length(a.position[i] - b.position[j]));
        worst.normalRadians = std::max(worst.normalRadians, angleBetween(a.normal[i], b.normal[j]));
        worst.lightMapUv = std::max(worst.lightMapUv, glm::length(a.uv[i] - b.uv[j]));
    }
    return worst;
}

/// A pair of triangles under its best turn.
struct Pair {
    double cost = 0;
    std::size_t original = 0, coded = 0;
    TriangleMatch difference;
};

Pair closestTurn(const std::vector<Corners>& original, std::size_t i, const std::vector<Corners>& coded, std::size_t j, double reach) {
    Pair best;
    best.cost = std::numeric_limits<double>::infinity();
    for (std::size_t turn = 0; turn < 3; ++turn) {
        const TriangleMatch found = difference(original[i], coded[j], turn);
        // Any weights that make the three comparable: a rounding step of position, a degree of normal and 1e-4 of UV count about alike.
        const double cost = found.position / reach + found.normalRadians * 60 + found.lightMapUv * 1e4;
        if (cost < best.cost) best = {cost, i, j, found};
    }
    return best;
}

using Cell = std::array<std::int64_t, 3>;
Cell cellOf(const glm::dvec3& point, double extent) {
    constexpr double kFarthest = 1e18;  // fits the integers; a copy may lie anywhere
    Cell cell{};
    for (int axis = 0; axis < 3; ++axis)
        cell[static_cast<std::size_t>(axis)] =
            static_cast<std::int64_t>(std::clamp(std::floor(point[axis] / extent), -kFarthest, kFarthest));
    return cell;
}

/// Pairs whose centroids lie within reach, sorted by how close they are.
std::vector<Pair> closePairs(const std::vector<Corners>& original, const std::vector<Corners>& coded, double reach) {
    std::map<Cell, std::vector<std::size_t>> cells;
    for (std::size_t j = 0; j < coded.size(); ++j) cells[cellOf(coded[j].centroid(), reach)].push_back(j);
    std::vector<Pair> pairs;
    for (std::size_t i = 0; i < original.size(); ++i) {
        const glm::dvec3 centroid = original[i].centroid();
        const Cell middle = cellOf(centroid, reach);
        for (int neighbour = 0; neighbour < 27; ++neighbour) {
            const auto found =
                cells.find({middle[0] + neighbour % 3 - 1, middle[1] + neighbour / 3 % 3 - 1, middle[2] + neighbour / 9 - 1});
            if (found == cells.end()) continue;
            for (const std::size_t j : found->second) {
                if (glm::length(coded[j].centroid() - centroid) <= reach) pairs.push_back(closestTurn(original, i, coded, j, reach));
            }
        }
    }
    std::sort(pairs.begin(), pairs.end(),
              [](const Pair& a, const Pair& b) { return std::tie(a.cost, a.original, a.coded) < std::tie(b.cost, b.original, b.coded); });
    return pairs;
}

double largestCoordinate(const std::vector<Corners>& triangles) {
    double largest = 0;
    for (const Corners& triangle : triangles) {
        for (const glm::dvec3& position : triangle.position) {
            largest = std::max({largest, std::abs(position.x), std::abs(position.y), std::abs(position.z)});
        }
    }
    return largest;
}

}  // namespace

std::size_t componentBytes(ComponentType type) {
    switch (type) {
        case ComponentType::Int8:
        case ComponentType::Uint8:
            return 1;
        case ComponentType::Int16:
        case ComponentType::Uint16:
            return 2;
        case ComponentType::Uint32:
        case ComponentType::Float32:
            return 4;
    }
    return 0;
}

glm::dvec3 MeshAttribute::at(std::size_t vertex) const {
    glm::dvec3 result(0);
    for (int i = 0; i < std::min(componentCount, 3); ++i) result[i] = component(vertex, i);
    return result;
}

double MeshAttribute::component(std::size_t vertex, int index) const {
    const std::byte* bytes = values.data() + offsetOf(*this, vertex, index);
    return visitType(componentType, [&](auto zero) { return componentAt<decltype(zero)>(bytes, isNormalized); });
}

double MeshAttribute::stored(std::size_t vertex, int index) const {
    const std::byte* bytes = values.data() + offsetOf(*this, vertex, index);
    return visitType(componentType, [&](auto zero) { return componentAt<decltype(zero)>(bytes, false); });
}

const MeshAttribute* TriangleMesh::find(std::string_view semantic) const {
    for (const MeshAttribute& attribute : attributes) {
        if (attribute.semantic == semantic) return &attribute;
    }
    return nullptr;
}

TriangleMesh withoutUnusedVertices(const TriangleMesh& mesh) {
    constexpr std::uint32_t kUnused = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> newIndex(mesh.vertexCount(), kUnused);
    for (const std::uint32_t index : mesh.indices) newIndex[index] = 0;
    std::uint32_t usedCount = 0;
    for (std::uint32_t& index : newIndex) {
        if (index != kUnused) index = usedCount++;
    }
    TriangleMesh used;
    for (const MeshAttribute& attribute : mesh.attributes) {
        MeshAttribute& kept = used.attributes.emplace_back(attribute);
        const std::size_t bytes = attribute.bytesPerVertex();
        kept.values.resize(usedCount * bytes);
        for (std::size_t vertex = 0; vertex < newIndex.size(); ++vertex) {
            if (newIndex[vertex] == kUnused) continue;
            std::memcpy(kept.values.data() + newIndex[vertex] * bytes, attribute.values.data() + vertex * bytes, bytes);
        }
    }
    for (const std::uint32_t index : mesh.indices) used.indices.push_back(newIndex[index]);
    return used;
}

tl::expected<TriangleMatch, std::string> matchTriangles(const TriangleMesh& original, const TriangleMesh& coded, double positionStep) {
    const bool normals = original.find("NORMAL") != nullptr && coded.find("NORMAL") != nullptr;
    const bool uvs = original.find("TEXCOORD_1") != nullptr && coded.find("TEXCOORD_1") != nullptr;
    // A copy with fewer triangles lost the degenerate ones. Keep degenerate triangles of the copy: rounding made them.
    const Degenerate degenerate = coded.triangleCount() == original.triangleCount() ? Degenerate::Keep : Degenerate::Drop;
    const std::vector<Corners> originals = cornersOf(original, normals, uvs, degenerate);
    const std::vector<Corners> copies = cornersOf(coded, normals, uvs, Degenerate::Keep);
    if (originals.size() != copies.size()) {
        return tl::make_unexpected(fmt::format("found {} triangles, expected {}", copies.size(), originals.size()));
    }
    const double reach = std::max(2 * positionStep, 1e-6 * largestCoordinate(originals) + 1e-30);
    std::vector<const Pair*> partner(originals.size(), nullptr);
    std::vector<const Pair*> nearest(originals.size(), nullptr);
    std::vector<bool> taken(copies.size(), false);
    const std::vector<Pair> pairs = closePairs(originals, copies, reach);
    for (const Pair& pair : pairs) {
        if (nearest[pair.original] == nullptr) nearest[pair.original] = &pair;
        if (partner[pair.original] != nullptr || taken[pair.coded]) continue;
        partner[pair.original] = &pair;
        taken[pair.coded] = true;
    }
    TriangleMatch worst;
    for (std::size_t i = 0; i < originals.size(); ++i) {
        // If triangles are smaller than the lattice, others may have taken all candidates of a triangle: compare it with the nearest one.
        const Pair* pair = partner[i] != nullptr ? partner[i] : nearest[i];
        if (pair == nullptr) {
            const glm::dvec3 at = originals[i].centroid();
            return tl::make_unexpected(
                fmt::format("found no counterpart of the triangle around ({}, {}, {}), expected one within {}", at.x, at.y, at.z, reach));
        }
        worst.position = std::max(worst.position, pair->difference.position);
        worst.normalRadians = std::max(worst.normalRadians, pair->difference.normalRadians);
        worst.lightMapUv = std::max(worst.lightMapUv, pair->difference.lightMapUv);
    }
    return worst;
}

}  // namespace lightcook::formats
