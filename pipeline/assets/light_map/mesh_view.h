// A small rasterizer: which place of a light map each pixel of a view of its mesh shows.
//
// Triangles are clipped at a plane in front of the camera, projected, and drawn with a depth buffer. UVs are interpolated divided by depth,
// as GPUs do. Both sides of a triangle are drawn.
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>
#include <optional>
#include <span>
#include <vector>

#include "formats/bake_axes.h"
#include "formats/gltf_scene.h"
#include "formats/image.h"
#include "verify/seams.h"

namespace lightcook::pipeline {

/// Returns the triangles that nodes draw and that have light-map UVs (TEXCOORD_1), in the world of the mesh.
std::vector<verify::SurfaceTriangle> litTriangles(const formats::GltfScene& scene);

/// Turns triangles into other axes. Their front stays the front under a reflection.
void turn(std::span<verify::SurfaceTriangle> triangles, const formats::BakeAxes& axes);

/// A place of a mesh.
struct MeshPlace {
    glm::dvec3 position{0}, normal{0};  ///< normal: unit, of the triangle's winding
    double texelSide = 0;               ///< of a texel on the triangle [scene units]
};
/// Returns the place with some UVs, on the first triangle that holds them. If none does, as at the rim of a chart, the nearest place of
/// a triangle that is less than one texel away. Empty if there is none.
/// size  of the light map [texels]
std::optional<MeshPlace> placeAt(std::span<const verify::SurfaceTriangle> triangles, const glm::dvec2& uv, const glm::dvec2& size);

struct MeshCamera {
    glm::dvec3 eye{0}, right{0}, up{0}, forward{0};  ///< orthonormal
    double slope = 0.5;                              ///< half of the picture's side at distance 1
    double nearest = 0;                              ///< distance of the clipping plane [scene units]
};
/// Returns a camera in front of a place, which looks back along the normal. It stays in front of whatever lies between.
/// radius    half of the picture's side at the place [scene units]
/// distance  receives that of the camera [scene units]
MeshCamera cameraInFrontOf(std::span<const verify::SurfaceTriangle> triangles, const MeshPlace& place, double radius, double& distance);

/// Returns the light-map UVs that the pixels of a view show, from the top left; NaN where the view shows no surface.
formats::Image<glm::dvec2> rasterized(std::span<const verify::SurfaceTriangle> triangles, const MeshCamera& camera, int side);

}  // namespace lightcook::pipeline
