// GLSL that fetches the texels of a light map and calls the function of lightcook.glsl that decodes them.
#pragma once

#include <nlohmann/json.hpp>
#include <string>

namespace example {

/// Returns GLSL to follow lightcook.glsl. It declares a sampler `map_ROLE` for each texture and `constants`, of a map with
/// detail also `detailConstants`, and defines
///   LcSh lightMapSh(vec2 uv, int cluster)
/// cluster is the vertex attribute _LIGHTCOOK_BASIS; only learned layouts read it. A flat map's light is the same from everywhere.
/// lightMap    entry of `assets` in cooked.json with `kind` "light-map"
/// include     text of lightcook.glsl
/// isOneTexel  true: of the texels that filter "decoded" mixes, lightMapSh() decodes one at random, each as often as it weighs. It follows
///             `uniform int frame`, so that a temporal filter sees others in each frame
/// Throws std::runtime_error for a layout that the example does not draw, and for isOneTexel of a map with filter "hardware".
std::string decodeGlsl(const nlohmann::json& lightMap, const std::string& include, bool isOneTexel);

}  // namespace example
