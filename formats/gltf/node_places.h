// Nodes of a glTF document at the places in a light map that a scene file states.
#pragma once

#include <string>
#include <vector>

#include "formats/gltf/gltf_document.h"
#include "formats/light_map_places.h"

namespace lightcook::formats {

/// Finds the place of each node that draws a mesh: its own, or that of the nearest node above it. Returns indices in `places` by index in
/// drawingNodes(), SIZE_MAX: none. Throws GltfFault for a place whose node is not in the document, or that several nodes fit.
std::vector<std::size_t> placesOfNodes(const GltfDocument& document, const std::vector<NodePlace>& places);

/// Moves the light-map UVs of nodes to their places. Nodes without a place draw nothing any more. Returns the names of these, where their
/// meshes have light-map UVs: "Room/Wall".
/// document  that follows the rules of scene_rules.h, without Draco streams
std::vector<std::string> placeNodes(GltfDocument& document, const std::vector<NodePlace>& places);

}  // namespace lightcook::formats
