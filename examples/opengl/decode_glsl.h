// GLSL that fetches the texels of a light map and calls the function of lightcook.glsl that decodes them.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace example {

/// Returns GLSL to follow lightcook.glsl. It declares a sampler `map_ROLE` for each texture and `constants`, of a map with
/// detail also `detailConstants`, and defines
///   LcSh lightMapSh(vec2 uv, int cluster)
/// cluster is the vertex attribute _LIGHTCOOK_BASIS; only learned layouts read it. A flat map's light is the same from everywhere.
/// lightMap  entry of `assets` in cooked.json with `kind` "light-map"
/// include   text of lightcook.glsl
std::string decodeGlsl(const nlohmann::json& lightMap, const std::string& include);

}  // namespace example
