// The light of the three directions of RNM light maps that shows nine SH coefficients best. Private to compress/.
//
// In the tangent frame a white surface shows sum_i w_i(n) R_i with w_i(n) = max(0, b_i . n). The best R minimizes the mean of
//   (sum_i w_i(n) R_i - E(n))^2   over the normals n of a ring, n.z from 1/2 to 9/10, with R_i >= 0
// The coefficients show E(n). Normal maps usually tilt normals by up to 60 degrees. The ring is that cap without its middle: a fit over the
// whole cap or hemisphere has a larger visible error (docs/lab/compress-light-maps.md).
//
// This is a nonnegative least squares problem with the normal equations G R = h, G_ij = mean of w_i w_j, h_i = mean of w_i E. h is linear
// in the coefficients. The b_i are one direction turned by 120 degrees about the normal, so that G has one number on its diagonal and one
// beside it, and h_1 and h_2 are h_0 of turned light. The optimum has some R_i = 0 and solves the equations of the others: of the few
// choices, the one of least cost with no negative number is exact.
#pragma once

#include <cstddef>
#include <glm/vec3.hpp>
#include <span>

#include "lighting/sh.h"

namespace lightcook::compress::rows {

class RnmFit {
public:
    /// light  coefficients of a channel in the tangent frame: x tangent, y bitangent (up a picture), z normal
    explicit RnmFit(const lighting::ShDouble& light);

    /// Returns the best light of the three directions, where the first ones are given: those of texels that are decoded already.
    /// known  0 to 2 numbers
    glm::dvec3 best(std::span<const double> known = {}) const;
    /// Returns the mean squared error of some light, less a constant of the coefficients.
    double cost(const glm::dvec3& light) const;

private:
    glm::dvec3 moments_;  ///< h
};

}  // namespace lightcook::compress::rows
