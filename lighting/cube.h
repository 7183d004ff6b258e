// Cubemap faces, in the order and orientation of OpenGL and Direct3D: +X -X +Y -Y +Z -Z.
// With u in [-1, 1] to the right and v in [-1, 1] down inside a face, the direction before normalisation is
//   +X (1,-v,-u)  -X (-1,-v,u)  +Y (u,1,v)  -Y (u,-1,-v)  +Z (u,-v,1)  -Z (-u,-v,-1)
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

namespace lightcook::lighting {

struct CubeCoordinate {
    int face = 0;      ///< 0..5
    glm::dvec2 uv{0};  ///< each in [-1, 1]
};

/// Returns the unit direction of a point of a face.
glm::dvec3 directionFromCube(CubeCoordinate coordinate);
CubeCoordinate cubeFromDirection(const glm::dvec3& direction);
/// Returns the unit direction of the centre of texel (x, y) of a face of size x size texels.
glm::dvec3 cubeTexelDirection(int face, int x, int y, int size);
/// Returns the solid angle of that texel [sr], exact: atan2 at its corners. The six faces add up to 4 pi.
double cubeTexelSolidAngle(int x, int y, int size);
/// Returns the solid angle of the rectangle from a face's centre to (u, v) [sr], with the sign of u v.
double cubeCornerSolidAngle(double u, double v);

}  // namespace lightcook::lighting
