// Environment probes as pre-divided, prefiltered cubemaps; the Cook-Torrance tables.
#pragma once

#include "formats/environment.h"
#include "pipeline/action.h"

namespace pipeline {

/// "cubemap". Inputs "source" and optionally "sh"; parameters: colors, probe_file (with "sh"), target, textures, size, repair.
formats::Result<ActionOutcome> cookCubemap(const ActionContext& context);
/// "lut". No input; parameters: distribution, normalization, view_count, m_rows, textures.
formats::Result<ActionOutcome> cookTables(const ActionContext& context);

/// "verify-cubemap", "verify-lut": upstream the cooked asset; parameters: max_error.
formats::Result<ActionOutcome> verifyCubemap(const ActionContext& context);
formats::Result<ActionOutcome> verifyTables(const ActionContext& context);

Json toJson(const formats::ColorSpaces& colors);
/// How an action reads its source. json   with members colors and repair
formats::EnvironmentOptions environmentOptions(const Json& json, const Action& action);

}  // namespace pipeline
