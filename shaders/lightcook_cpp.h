// The shared shader sources as C++ over GLM: shaders::lcExitRadiance(...) is the text that engines include. Texels, constants and
// results are glm vectors; see the .glsl files for each function.
#pragma once

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

namespace lightcook::shaders {
using glm::abs;
using glm::clamp;
using glm::cross;
using glm::dot;
using glm::exp;
using glm::exp2;
using glm::floor;
using glm::inversesqrt;
using glm::log2;
using glm::max;
using glm::min;
using glm::mix;
using glm::normalize;
using glm::sqrt;
using glm::vec2;
using glm::vec3;
using glm::vec4;

/// Texture "tables" of a learned layout: rows of `width` texels.
struct LcTables {
    const vec4* texels = nullptr;
    int width = 0;
};
inline vec4 lcTableTexel(const LcTables& tables, int column, int row) {
    return tables.texels[static_cast<long>(row) * tables.width + column];
}

// Shared functions are inlined: the verifier calls decoders in its innermost loop.
#define LC_FUNCTION inline
#define LC_TABLES const LcTables&
// clang-format off
#include "shaders/prelude.glsl"
#include "shaders/sh.glsl"
#include "shaders/filter.glsl"
#include "shaders/light_map_raw.glsl"
#include "shaders/light_map_flat.glsl"
#include "shaders/light_map_ratio.glsl"
#include "shaders/light_map_basis.glsl"
#include "shaders/light_map_sh4.glsl"
#include "shaders/light_map_godot.glsl"
#include "shaders/light_map_bakery.glsl"
#include "shaders/light_map_hdr.glsl"
#include "shaders/light_map_halo3.glsl"
#include "shaders/light_map_unreal.glsl"
#include "shaders/light_map_rnm.glsl"
#include "shaders/light_map_lit.glsl"
#include "shaders/dominant.glsl"
#include "shaders/specular.glsl"
#include "shaders/environment.glsl"
#include "shaders/rsrm.glsl"
// clang-format on
#undef LC_FUNCTION
#undef LC_TABLES
}  // namespace lightcook::shaders
