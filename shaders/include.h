// The shader text that an engine includes: the shared sources of this folder, embedded at build time and put together for the layouts that
// a scene uses. The text compiles as GLSL 4.50, as GLSL ES 3.00 and as HLSL; define LIGHTCOOK_HLSL before including it in HLSL.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace lightcook::shaders {

struct ShaderSource {
    std::string_view name;  ///< "light_map_luvw.glsl"
    std::string_view text;
};
/// Every shared source, in an order in which each needs only those before it.
std::span<const ShaderSource> allSources();

/// One file `lightcook.glsl` for the light-map layouts named ("raw", "flat", "luvw", "ratio", "zh3", "basis-4"; unknown names are a broken
/// promise) with the specular, environment and RSRM functions. The same layouts give the same text, in any order and however often named.
std::string shaderInclude(std::span<const std::string> layouts);

}  // namespace lightcook::shaders
