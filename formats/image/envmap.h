// Environments that OpenEXR's attribute `envmap` describes, brought to the directions and texel centres of environment.h.
//
// OpenEXR draws the faces of a cube as they are seen from outside, ours are seen from inside: +-X and +-Z are mirrored from left to right,
// +-Y from top to bottom. The middle of its panoramas is +Z, that of ours is -Z: they differ by half a turn. And the first and the last
// texel of a row or column lie on the edges of a face, or on the poles and the seam of a panorama, where ours lie half a texel inside. So
// each of our texels is interpolated bilinearly between the four of theirs around its direction. Source: ImfEnvmap.h of OpenEXR 3.
#pragma once

#include <glm/vec3.hpp>
#include <glm/vec4.hpp>
#include <string>

#include "formats/error.h"
#include "formats/image.h"
#include "formats/plain_image.h"

namespace lightcook::formats {

/// Fails for an image that does not have the shape of its environment: 1:6 for a cube, 2:1 for a panorama.
/// subject  names the image in errors
Result<void> checkEnvironmentShape(int width, int height, ExrEnvironment environment, const Subject& subject);

/// Returns an image of the same size, resampled: a vertical strip of faces +X -X +Y -Y +Z -Z, or an equirectangular panorama.
/// texels  of the shape that checkEnvironmentShape() asks for
Image<glm::vec3> fromExrEnvironment(const Image<glm::vec3>& texels, ExrEnvironment environment);
Image<glm::vec4> fromExrEnvironment(const Image<glm::vec4>& texels, ExrEnvironment environment);

}  // namespace lightcook::formats
