#include "formats/gltf/node_placement.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <glm/ext/matrix_transform.hpp>
#include <glm/gtc/quaternion.hpp>
#include <optional>

namespace lightcook::formats {
namespace {

/// Returns the numbers of an array of that length, or nothing.
template <std::size_t N>
std::optional<std::array<double, N>> numbersOf(const nlohmann::json& node, const char* key) {
    const auto found = node.find(key);
    if (found == node.end() || !found->is_array() || found->size() != N) return std::nullopt;
    std::array<double, N> values{};
    for (std::size_t i = 0; i < N; ++i) {
        if (!(*found)[i].is_number()) return std::nullopt;
        values[i] = (*found)[i].get<double>();
    }
    return values;
}

/// Returns the transform from a node's space to that of its parent.
glm::dmat4 localTransform(const nlohmann::json& node) {
    glm::dmat4 transform(1);
    if (const auto matrix = numbersOf<16>(node, "matrix")) {
        for (std::size_t i = 0; i < 16; ++i) transform[static_cast<glm::length_t>(i / 4)][static_cast<glm::length_t>(i % 4)] = (*matrix)[i];
        return transform;
    }
    if (const auto t = numbersOf<3>(node, "translation")) transform = glm::translate(transform, glm::dvec3((*t)[0], (*t)[1], (*t)[2]));
    if (const auto r = numbersOf<4>(node, "rotation")) transform *= glm::mat4_cast(glm::dquat((*r)[3], (*r)[0], (*r)[1], (*r)[2]));
    if (const auto s = numbersOf<3>(node, "scale")) transform = glm::scale(transform, glm::dvec3((*s)[0], (*s)[1], (*s)[2]));
    return transform;
}

/// Returns the indices of an array that name one of `count` elements.
std::vector<std::size_t> indicesOf(const nlohmann::json& owner, const char* key, std::size_t count) {
    std::vector<std::size_t> indices;
    const auto found = owner.find(key);
    if (found == owner.end() || !found->is_array()) return indices;
    for (const nlohmann::json& each : *found)
        if (each.is_number_unsigned() && each.get<std::uint64_t>() < count) indices.push_back(each.get<std::size_t>());
    return indices;
}

std::vector<std::size_t> rootsOf(const nlohmann::json& gltf, const nlohmann::json& nodes) {
    const auto scenes = gltf.find("scenes");
    if (scenes != gltf.end() && scenes->is_array() && !scenes->empty()) {
        const auto scene = gltf.find("scene");
        const std::uint64_t index = scene != gltf.end() && scene->is_number_unsigned() ? scene->get<std::uint64_t>() : 0;
        return index < scenes->size() ? indicesOf((*scenes)[index], "nodes", nodes.size()) : std::vector<std::size_t>();
    }
    std::vector<bool> isChild(nodes.size(), false);
    for (const nlohmann::json& node : nodes)
        for (const std::size_t child : indicesOf(node, "children", nodes.size())) isChild[child] = true;
    std::vector<std::size_t> roots;
    for (std::size_t i = 0; i < nodes.size(); ++i)
        if (!isChild[i]) roots.push_back(i);
    return roots;
}

/// Calls visit(index, world transform, depth) for each node below the roots, once; roots have depth 1.
template <class Work>
void visitNodes(const nlohmann::json& gltf, Work visit) {
    const auto nodes = gltf.find("nodes");
    if (nodes == gltf.end() || !nodes->is_array()) return;
    struct Visit {
        std::size_t node, depth;
        glm::dmat4 parent;
    };
    std::vector<Visit> waiting;
    for (const std::size_t root : rootsOf(gltf, *nodes)) waiting.push_back({root, 1, glm::dmat4(1)});
    std::vector<bool> isVisited(nodes->size(), false);
    while (!waiting.empty()) {
        const Visit next = waiting.back();
        waiting.pop_back();
        if (isVisited[next.node]) continue;
        isVisited[next.node] = true;
        const nlohmann::json& node = (*nodes)[next.node];
        if (!node.is_object()) continue;
        const glm::dmat4 world = next.parent * localTransform(node);
        visit(next.node, world, next.depth);
        for (const std::size_t child : indicesOf(node, "children", nodes->size())) waiting.push_back({child, next.depth + 1, world});
    }
}

/// Returns the mesh that a node of the document draws, if any.
std::optional<std::uint64_t> meshOfNode(const nlohmann::json& gltf, std::size_t index) {
    const nlohmann::json& node = gltf["nodes"][index];
    const auto mesh = node.find("mesh");
    return mesh != node.end() && mesh->is_number_unsigned() ? std::optional(mesh->get<std::uint64_t>()) : std::nullopt;
}

}  // namespace

std::map<std::uint64_t, std::vector<NodePlacement>> placesOfMeshes(const nlohmann::json& gltf) {
    std::map<std::uint64_t, std::vector<NodePlacement>> places;
    visitNodes(gltf, [&](std::size_t node, const glm::dmat4& world, std::size_t) {
        if (const auto mesh = meshOfNode(gltf, node)) places[*mesh].push_back({node, world});
    });
    return places;
}

std::vector<std::size_t> drawingNodes(const nlohmann::json& gltf) {
    std::vector<std::size_t> nodes;
    visitNodes(gltf, [&](std::size_t node, const glm::dmat4&, std::size_t) {
        if (meshOfNode(gltf, node)) nodes.push_back(node);
    });
    std::ranges::sort(nodes);
    return nodes;
}

std::size_t depthOfNodes(const nlohmann::json& gltf) {
    std::size_t deepest = 0;
    visitNodes(gltf, [&](std::size_t, const glm::dmat4&, std::size_t depth) { deepest = std::max(deepest, depth); });
    return deepest;
}

}  // namespace lightcook::formats
