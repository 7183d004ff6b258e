// A gradient around an axis from an environment: each zone of equal solid angle takes the mean of what it holds of every texel.
#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "formats/environment.h"
#include "formats/error.h"

namespace lightcook::fit {

struct AzimuthalAverage {
    std::vector<glm::vec3> gradient;  ///< zones of equal solid angle, from the axis (north) to its opposite, as makeRsrm takes them
    /// Share of the light's energy (squares of radiance over the sphere, all channels) that the gradient lost: 0 is light that was
    /// symmetric around the axis, and black; 1 at most.
    double asymmetricEnergy = 0;
};

/// Refuses an axis that is zero or not finite, and zone counts outside 1 .. 4096.
formats::Result<void> checkAzimuthalAverage(const glm::dvec3& axis, int zoneCount);

/// environment  of any size; texels are constant over their part of the sphere, and finite
/// axis         world direction of the gradient's north, of any length; must pass the check
/// The part of a texel that lies in a zone is a closed form: by Green's theorem the area above a height h is the integral of (z - h) d phi
/// along those parts of the texel's sides that are above h, each of which is an arc of a circle. Exact but for rounding, around an
/// axis turned by 1e-8 (so that no side of a texel passes through it).
AzimuthalAverage averageAroundAxis(const formats::Environment& environment, const glm::dvec3& axis, int zoneCount);

}  // namespace lightcook::fit
