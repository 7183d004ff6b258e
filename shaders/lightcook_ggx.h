// The specular shader source of a scene whose lobe is GGX, as C++: shaders::ggx::lcDominantSpecular(...) is the text that engines include
// with LIGHTCOOK_GGX defined.
#pragma once

#include "shaders/lightcook_cpp.h"

namespace lightcook::shaders::ggx {
#define LC_FUNCTION inline
#define LIGHTCOOK_GGX
#undef LIGHTCOOK_SPECULAR_GLSL
#include "shaders/specular.glsl"
#undef LIGHTCOOK_GGX
#undef LC_FUNCTION
}  // namespace lightcook::shaders::ggx
