// The light-map UVs of a glTF primitive, which exporters and packers store otherwise than as TEXCOORD_1 of the whole map:
//
//   MOZ_lightmap             the light map of the material names the UV set (texCoord), and may transform it (KHR_texture_transform)
//   gltfpack                 UVs are integers that a KHR_texture_transform on each texture of the material brings to their range. Which of
//                            the sets has textures does not matter: one transform is made for all sets of a material
//   other quantizers         UVs are integers; a KHR_texture_transform that all textures of TEXCOORD_1 share brings them to their range
//
// All else is TEXCOORD_1 as it is stored: a transform of a texture over UVs of floats tiles this texture, and says nothing of the light
// map. Source: KHR_texture_transform (Khronos), of which the rotation is counterclockwise with v down, as its example and test model have
// it.
#pragma once

#include <cstdint>
#include <glm/mat2x2.hpp>
#include <glm/vec2.hpp>

#include "formats/gltf/gltf_document.h"

namespace lightcook::formats {

/// Attribute of light-map UVs in the whole map.
inline constexpr const char* kLightMapUvs = "TEXCOORD_1";

/// KHR_texture_transform of a texture: uv becomes matrix * uv + offset.
struct UvTransform {
    glm::dmat2 matrix{1};
    glm::dvec2 offset{0};
    bool operator==(const UvTransform&) const = default;
    bool isIdentity() const { return *this == UvTransform(); }
    glm::dvec2 operator()(const glm::dvec2& uv) const { return matrix * uv + offset; }
};

/// Light-map UVs of a primitive: a set, and the transform that brings it to the map.
struct LightMapUvs {
    std::uint64_t set = 1;
    UvTransform transform = {};
    bool isPlain() const { return set == 1 && transform.isIdentity(); }
};

/// Returns the light-map UVs of a primitive. Reads no buffers.
LightMapUvs lightMapUvsOf(const GltfDocument& document, const Json& primitive);
/// Returns true if a primitive has light-map UVs. Reads no buffers.
bool hasLightMapUvs(const GltfDocument& document, const Json& primitive);
/// Returns true if light-map UVs of triangles are stored otherwise than as TEXCOORD_1 of the whole map.
bool hasOtherLightMapUvs(const GltfDocument& document);

/// Stores the light-map UVs of triangles as TEXCOORD_1 of the whole map. A set that textures still need becomes the first free one, and
/// they take it from there; a transform that is in the UVs now is removed from its textures. Throws GltfFault if a set is missing.
/// document  that follows the rules of scene_rules.h, without Draco streams
void storeLightMapUvs(GltfDocument& document);

}  // namespace lightcook::formats
