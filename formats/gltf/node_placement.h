// Places of meshes in the world, through the nodes of a glTF scene.
#pragma once

#include <cstddef>
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <map>
#include <nlohmann/json.hpp>
#include <vector>

namespace lightcook::formats {

/// A mesh as a node draws it.
struct NodePlacement {
    std::size_t node;
    glm::dmat4 worldFromMesh;
};

/// Returns the placements of each mesh, by its index: one for every node of the default scene that draws it, by glTF 2.0 section 3.5.
/// Without any scene the roots are the nodes that no other node names. Nodes of wrong shape count as untransformed, and one
/// that is its own ancestor is visited once.
std::map<std::uint64_t, std::vector<NodePlacement>> placesOfMeshes(const nlohmann::json& gltf);

/// Returns the nodes of the default scene that draw a mesh, by their indices, in ascending order.
std::vector<std::size_t> drawingNodes(const nlohmann::json& gltf);

/// Returns the number of nodes of the longest path from a root to a leaf. A node that is its own ancestor is visited once.
std::size_t depthOfNodes(const nlohmann::json& gltf);

}  // namespace lightcook::formats
