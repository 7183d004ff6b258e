// lightcook compare for two light maps: the errors of shaded light at texel centres.
#pragma once

#include <filesystem>

#include "formats/error.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// Returns true for files whose channels or names say that they hold a light map, and no picture.
bool isCertainLightMap(const std::filesystem::path& file);

/// Returns {"width","height","texels","diffuse","specular"}: errors of the light of `b` against that of `a`, each {"rel_rms","p99","max",
/// "visible"} with visible errors {"rms","p50","p95","p99","p999","max"}. They are those of `at_texels` in a report without materials: of
/// the texels that `a` covers, about its normals, on the default display (docs/theory/error.md and visible.md). Coverage or normals that
/// `a` lacks are those of `b`; state.warning is called where neither has them. Fails for files that are no light maps, that need their
/// mesh, that differ in size, and for a bake that covers nothing.
formats::Result<Json> compareLightMaps(const std::filesystem::path& a, const std::filesystem::path& b, const RunState& state);

}  // namespace lightcook::pipeline
