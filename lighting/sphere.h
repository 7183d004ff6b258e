// Directions, frames, point sets and panoramas of the sphere.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace lightcook::lighting {

/// Returns an orthonormal frame (columns: tangent, bitangent, normal) around a unit normal. Source: Duff et al. 2017, Building an
/// Orthonormal Basis, Revisited.
glm::dmat3 worldFromTangentFrame(const glm::dvec3& normal);

/// Returns point `index` of `count` spherical Fibonacci points of the upper hemisphere: z = (i + 0.5) / n, phi = i pi (3 - sqrt 5).
glm::dvec3 fibonacciHemisphere(int index, int count);
/// Returns the same over the whole sphere: z = 1 - (2i + 1) / n.
glm::dvec3 fibonacciSphere(int index, int count);

/// Convert between directions and the coordinates of equirectangular panoramas: u = 0.5 + atan2(x, -z) / 2pi, v = acos(y) / pi, v = 0 on
/// top; the centre is -Z.
glm::dvec2 equirectangularFromDirection(const glm::dvec3& direction);
glm::dvec3 directionFromEquirectangular(const glm::dvec2& uv);
/// Returns the solid angle of a texel of row y [sr]: the exact area of its latitude-longitude rectangle.
double equirectangularTexelSolidAngle(int y, int width, int height);

}  // namespace lightcook::lighting
