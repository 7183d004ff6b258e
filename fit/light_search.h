// The best directional light of a texel's quadratic SH, over all directions.
//
// Minimises the squared error over nine coefficients i and three channels k,
//   E(d, c, a) = sum_k sum_i (lambda_ik - c_k Y_i(d) - a_k 2 sqrt(pi) [i = 0])^2,
// with direction d, intensity c >= 0 and ambient radiance a >= 0. By Parseval this is the squared difference of the two quadratic SH
// functions, integrated over the sphere. Method (variable projection):
// 1. For a direction, c and a are a closed-form least squares in each channel, so E is a function of d alone.
// 2. The gain of 256 grid directions, at most 11 degrees from any direction, is computed in float lanes.
// 3. Each local maximum of the grid within 75 % of the highest is a start of Newton's method on the sphere. A typical E has four
//    local minima.
// Source of the closed form: Chen and Liu 2008, Lighting and Material of Halo 3, section 1.4.1.
#pragma once

#include <glm/vec3.hpp>

#include "lighting/sh.h"

namespace lightcook::fit {

struct LightFit {
    glm::dvec3 direction{0, 0, 1};  ///< towards the light, unit
    glm::dvec3 intensity{0};        ///< radiometric delta, at least 0
    glm::dvec3 ambient{0};          ///< radiance from everywhere, at least 0; 0 if it was not requested
    double unexplained = 0;         ///< E / sum lambda^2, in [0, 1]; 0 for black
};

/// Returns the best intensity and ambient light for a unit direction. All functions here are finite for finite input.
LightFit lightTowards(const lighting::ShRgb& incident, const glm::dvec3& direction, bool hasAmbient);

/// Returns the best light over all directions.
/// hint  a unit direction; the result is at least as good, and ties go to it
LightFit bestLight(const lighting::ShRgb& incident, const glm::dvec3& hint, bool hasAmbient);

/// Returns a lower bound of `unexplained` for any direction, from the norms of the bands: |Lambda' Y(d)| <= sum_l sqrt((2l + 1) / 4pi)
/// |Lambda_l|, with equality for a directional light. With ambient light only bands 1 and 2 count.
double leastUnexplained(const lighting::ShRgb& incident, bool hasAmbient);

/// Two lights and one ambient term.
struct TwoLights {
    LightFit first, second;  ///< the brighter (sum of channels) first; ambient is that of `first`
    double unexplained = 0;
};
/// Returns two lights that explain a texel, to estimate the gain of a second light. Each light is fitted in turn to what the other leaves,
/// so the result is a local minimum: `unexplained` is an upper bound of the error of the best two lights.
/// hint  as for bestLight()
TwoLights bestTwoLights(const lighting::ShRgb& incident, const glm::dvec3& hint, bool hasAmbient);

}  // namespace lightcook::fit
