// The best single directional light of a texel's quadratic SH: over all directions, with intensity and ambient light in closed form.
// Source: Chen and Liu, Lighting and Material of Halo 3, section 1.4.1, with lighting-math section 3; the variable projection is ours.
//
// Minimised is the squared error of all nine coefficients and three channels,
//   E(d, c, a) = sum_k sum_i (lambda_ik - c_k Y_i(d) - a_k 2 sqrt(pi) [i = 0])^2,
// which by Parseval is the integral over the sphere of the squared difference between the light as quadratic SH and the delta (and the
// constant) as quadratic SH: what the closed form minimises over c alone. For a direction, c and a are a least squares of one or two
// unknowns at least 0 a channel, so E is a function of d: four local minima or so, found from a grid and finished by Newton on the sphere.
#pragma once

#include <glm/vec3.hpp>

#include "lighting/sh.h"

namespace lightcook::fit {

struct LightFit {
    glm::dvec3 direction{0, 0, 1};  ///< towards the light, unit
    glm::dvec3 intensity{0};        ///< radiometric delta, at least 0
    glm::dvec3 ambient{0};          ///< radiance from everywhere, at least 0; 0 where it was not asked for
    double unexplained = 0;         ///< least E / sum lambda^2 for that direction, in [0, 1]; 0 for black
};

/// Intensity and ambient light that fit best for a unit direction. All functions here are finite for finite input.
LightFit lightTowards(const lighting::ShRgb& incident, const glm::dvec3& direction, bool hasAmbient);

/// The best light over all directions. hint: a unit direction to be no worse than; it also settles ties.
LightFit bestLight(const lighting::ShRgb& incident, const glm::dvec3& hint, bool hasAmbient);

/// A lower bound on `unexplained` of any direction, from the norms of the bands alone: |Lambda' Y(d)| <= sum_l sqrt((2l + 1) / 4pi)
/// |Lambda_l|, with equality for one directional light. With ambient light, of bands 1 and 2.
double leastUnexplained(const lighting::ShRgb& incident, bool hasAmbient);

/// Two lights (and one ambient term): what a second one would give where one cannot explain the light. A local minimum, found by fitting
/// each light in turn to what the other leaves, so an upper bound on what two lights leave.
struct TwoLights {
    LightFit first, second;  ///< the brighter (sum of channels) first; ambient is that of `first`
    double unexplained = 0;
};
TwoLights bestTwoLights(const lighting::ShRgb& incident, const glm::dvec3& hint, bool hasAmbient);

}  // namespace lightcook::fit
