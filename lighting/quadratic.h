// Quadratic polynomials on the unit sphere, q(n) = constant + linear . n + n' symmetric n, and their exact extrema.
#pragma once

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "lighting/sh.h"

namespace lightcook::lighting {

struct SphereQuadratic {
    double constant = 0;
    glm::dvec3 linear{0};
    glm::dmat3 symmetric{0};

    double operator()(const glm::dvec3& n) const;
};

/// Returns the polynomial whose values on the sphere are sum_i bands_l(i) coefficients_i Y_i(n).
SphereQuadratic sphereQuadratic(const ShDouble& coefficients, const ShBands& bands);

struct Extrema {
    double minimum = 0, maximum = 0;
    glm::dvec3 minimumAt{0, 0, 1}, maximumAt{0, 0, 1};  ///< unit
};
/// Returns the exact extrema over the unit sphere. Error: at most 1e-12 of |constant| + |linear| + |symmetric|, if that
/// is between 1e-307 and 1e307.
/// Method: one 3 x 3 symmetric eigenproblem, and a secular equation for each extremum (the trust-region problem on its boundary, hard case
/// included). Source: More and Sorensen 1983, Computing a Trust Region Step.
Extrema extremaOnSphere(const SphereQuadratic& quadratic);

}  // namespace lightcook::lighting
