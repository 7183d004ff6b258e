// Nodes of a glTF document at their places in a light map of Godot.
#pragma once

#include "formats/gltf/gltf_document.h"
#include "formats/lmbake.h"

namespace lightcook::formats {

/// Moves the light-map UVs (TEXCOORD_1) of each node that the lmbake has into its rectangle of the whole map: of n slices, slice i has the
/// V coordinates (i + v) / n. A mesh that several nodes draw becomes a mesh for each; nodes that the lmbake does not have lose these UVs.
/// Throws GltfFault, and fails if it has none of the nodes.
/// document  that follows the rules of scene_rules.h, without Draco streams
/// source    of `lmbake`, for errors
LmbakeMatch placeNodes(GltfDocument& document, const Lmbake& lmbake, const std::filesystem::path& source);

}  // namespace lightcook::formats
