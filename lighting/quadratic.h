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

/// The polynomial whose values on the sphere are sum_i bands_l(i) coefficients_i Y_i(n).
SphereQuadratic sphereQuadratic(const ShDouble& coefficients, const ShBands& bands);

struct Extrema {
    double minimum = 0, maximum = 0;
    glm::dvec3 minimumAt{0, 0, 1}, maximumAt{0, 0, 1};  ///< unit
};
/// Exact extrema over the unit sphere: one 3 x 3 symmetric eigenproblem and a secular equation for each end (the trust-region problem
/// with the sphere as its boundary, hard case included). Relative error at most 1e-12 of |constant| + |linear| + |symmetric|.
Extrema extremaOnSphere(const SphereQuadratic& quadratic);

/// Bound on |sum_i bands_l(i) coefficients_i Y_i(n)| over every n, without an eigenproblem: sum_l |bands_l| sqrt((2l + 1) / 4pi)
/// |coefficients of band l|.
double bandNormBound(const ShDouble& coefficients, const ShBands& bands);

}  // namespace lightcook::lighting
