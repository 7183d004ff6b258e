// The shader text that an engine includes. The sources of this folder are embedded at build time and joined for the layouts of a scene.
// The text compiles as GLSL 4.50, as GLSL ES 3.00 and as HLSL; define LIGHTCOOK_HLSL before including it in HLSL.
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace lightcook::shaders {

struct ShaderSource {
    std::string_view name;  ///< "light_map_ratio.glsl"
    std::string_view text;
};
/// Returns every shared source, in an order in which each needs only those before it. The order is that of shaders/CMakeLists.txt.
std::span<const ShaderSource> allSources();

/// Returns true if there is a source light_map_<family>.glsl.
bool hasLightMapFamily(std::string_view family);

/// Distribution of the specular functions. They call lcBeckmann unless LIGHTCOOK_GGX is defined.
enum class Distribution { Beckmann, Ggx };

/// Returns the text of `lightcook.glsl`: the sources of some families of light-map layouts, and all sources that are not of a light map
/// (harmonics, specular, environment, RSRM). The text depends only on the set of families, not on their order or repetition, and on the
/// distribution: that of GGX begins with its definition.
/// families  names of light_map_<family>.glsl, as formats::lightMapFamilies() gives them; each must exist
std::string shaderInclude(std::span<const std::string> families, Distribution distribution = Distribution::Beckmann);

}  // namespace lightcook::shaders
