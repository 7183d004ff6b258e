// Azimuthal average of an environment: the gradient around an axis that a radially symmetric reflection map (rsrm.h) is made from. Each
// zone takes the exact mean radiance over its part of the sphere.
#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "formats/environment.h"
#include "formats/error.h"

namespace lightcook::fit {

struct AzimuthalAverage {
    std::vector<glm::vec3> gradient;  ///< zones of equal solid angle, from the axis (north) to its opposite: the input of makeRsrm
    /// Share of the energy (squared radiance over the sphere, all channels) that is not in the gradient, in [0, 1]. 0 for black and for
    /// light that is rotationally symmetric around the axis.
    double asymmetricEnergy = 0;
};

/// Refuses an axis that is zero or not finite, and zone counts outside 1 .. 4096.
formats::Result<void> checkAzimuthalAverage(const glm::dvec3& axis, int zoneCount);

/// Returns the average around an axis, exact up to rounding.
/// environment  of any size; finite texels, each constant over its part of the sphere
/// axis         world direction of the gradient's north, of any length; must pass the check
/// Method: the area of a texel above a height h is, by Green's theorem, the integral of (z - h) d phi along the parts of its sides above h.
/// Sides are arcs of circles, so the integral is a closed form. The axis is turned by 1e-8, so that no side of a texel passes through it.
AzimuthalAverage averageAroundAxis(const formats::Environment& environment, const glm::dvec3& axis, int zoneCount);

}  // namespace lightcook::fit
