// The dominant light of a light map, as a filterable direction texture and an HDR intensity texture.
#pragma once

#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// "dominant". Input "source"; parameters: description, fit, target, textures.
formats::Result<ActionOutcome> cookDominant(const ActionContext& context);
/// "verify-dominant". Input "source"; upstream: the cooked textures; parameters: max_error, shading.
formats::Result<ActionOutcome> verifyDominant(const ActionContext& context);

}  // namespace lightcook::pipeline
