// Decodes the colours of 8-bit light maps. Unity stores them in gamma space, samples R, G and B through the sRGB curve (not alpha), and
// multiplies in the shader; the product is linear:
//
//   rgbm   34.493242 a^2.2 linear(r, g, b)    34.493242 = 5^2.2: up to 5 in gamma space
//   dldr   4.59 linear(r, g, b)               4.59 = 2^2.2 as the shader has it: up to 2 in gamma space
//
// Source: Unity, Packages/com.unity.render-pipelines.core/ShaderLibrary/EntityLighting.hlsl; manual, "Lightmaps: Technical information".
#pragma once

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>

#include "formats/light_map_conventions.h"

namespace lightcook::formats {

/// Returns the linear light of a stored texel.
/// stored  R, G, B, A in [0, 1]; A counts for RGBM only
glm::vec3 decodedLight(const glm::vec4& stored, LightEncoding encoding);

}  // namespace lightcook::formats
