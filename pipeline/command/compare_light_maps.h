// lightcook compare for two light maps: the errors of shaded light at texel centres.
#pragma once

#include <filesystem>

#include "formats/error.h"
#include "formats/light_map.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// A light map, and the conventions that it is read by.
struct ComparedMap {
    std::filesystem::path file;
    formats::LightMapDescription description = {};
};

/// Returns true for files whose channels or names say that they hold a light map, and no picture, and for those of a bake format that is
/// named.
bool isCertainLightMap(const ComparedMap& map);

/// Returns {"width","height","texels","diffuse","specular"}: errors of the light of `b` against that of `a`, each {"rel_rms","p99","max",
/// "visible"} with visible errors {"rms","p50","p95","p99","p999","max"}. They are those of `at_texels` in a report without materials: of
/// the texels that `a` covers, about its normals, on the default display (docs/theory/error.md and visible.md). Coverage or normals that
/// `a` lacks are those of `b`; state.warning is called where neither has them. Fails for files that are no light maps, that need a mesh
/// and have none, that differ in size, and for a bake that covers nothing.
formats::Result<Json> compareLightMaps(const ComparedMap& a, const ComparedMap& b, const RunState& state);

}  // namespace lightcook::pipeline
