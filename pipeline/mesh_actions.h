// Meshes: what their materials need, and the same mesh quantized for the engine.
#pragma once

#include "pipeline/action.h"

namespace pipeline {

/// "materials". Input "mesh": the needs of each material, as facts.
formats::Result<ActionOutcome> readMaterials(const ActionContext& context);
/// "mesh". Input "mesh"; parameters: file, draco options.
formats::Result<ActionOutcome> cookMesh(const ActionContext& context);
/// "verify-mesh". Inputs "mesh" and "source" (the light map); upstream: the cooked mesh; parameters: max_error, description.
formats::Result<ActionOutcome> verifyMesh(const ActionContext& context);

}  // namespace pipeline
