// Environment probes as pre-divided, prefiltered cubemaps; the Cook-Torrance tables.
#pragma once

#include <optional>

#include "formats/environment.h"
#include "lighting/area_specular.h"
#include "pipeline/graph/action.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

/// "cubemap". Inputs "source" and optionally "sh"; parameters: colors, probe_file (with "sh"), target, textures, size, repair.
formats::Result<ActionOutcome> cookCubemap(const ActionContext& context);
/// "lut". No input; parameters: lobe, normalization, view_count, roughness_count, minimum_m, maximum_m, view_axis, roughness_axis, f0 (the
/// range that axes are chosen for), textures.
formats::Result<ActionOutcome> cookTables(const ActionContext& context);

/// "verify-cubemap", "verify-lut": upstream the cooked asset; parameters: max_error.
formats::Result<ActionOutcome> verifyCubemap(const ActionContext& context);
formats::Result<ActionOutcome> verifyTables(const ActionContext& context);

/// By its name in the manifest; nothing for a name that is not among kLobeNames.
std::optional<lighting::SpecularLobe> lobeOf(const std::string& name);

Json toJson(const formats::ColorSpaces& colors);
/// How an action reads its source. json   with members colors and repair
formats::EnvironmentOptions environmentOptions(const Json& json, const Action& action);

}  // namespace lightcook::pipeline
