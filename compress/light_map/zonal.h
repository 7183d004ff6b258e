// Light that is round about the axis of its own linear band: what layouts "luvw-linear" and "zh3" keep of band 2. Private to compress/.
#pragma once

#include <glm/vec3.hpp>

#include "lighting/sh.h"

namespace lightcook::compress::rows {

/// The direction of band 1 (coefficients 1, 2, 3) as luminance sees it; 0 where that is 0. Light of any unit.
glm::vec3 linearAxis(const glm::vec3& c1, const glm::vec3& c2, const glm::vec3& c3, const glm::vec3& luminanceWeights);
/// Each channel's band 2 along a unit axis: the numbers z that bring z sqrt(4 pi / 5) Y_2m(axis) nearest to it. 0 for axis 0.
glm::vec3 zonalAlong(const lighting::ShRgb& sh, const glm::vec3& axis);
/// The same as the intensity of one light from the axis, at least 0. Halo 3 fits it to all nine coefficients; but only band 2 is restored
/// from it, and light from everywhere must not look like a lamp along what noise its band 1 has.
glm::vec3 intensityAlong(const lighting::ShRgb& sh, const glm::vec3& axis);

}  // namespace lightcook::compress::rows
