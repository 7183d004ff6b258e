// Meshes: what their materials need, and the same mesh quantized for the engine.
#pragma once

#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// Input of an action that reads a mesh.
inline constexpr const char* kMeshRole = "mesh";

/// "materials". Input "mesh": the needs of each material, as facts.
formats::Result<ActionOutcome> readMaterials(const ActionContext& context);
/// "mesh". Input "mesh"; parameters: description, draco; upstream: the light map where its bases are learned, for the vertices' clusters.
formats::Result<ActionOutcome> cookMesh(const ActionContext& context);
/// "verify-mesh". Inputs "mesh" and "source" (the light map); upstream: the cooked mesh, and the light map again; parameters: max_error,
/// description.
formats::Result<ActionOutcome> verifyMesh(const ActionContext& context);

}  // namespace lightcook::pipeline
