// The gradient around an axis of an environment, found another way than fit's: along lines through the texels, cut where zones begin.
#pragma once

#include <glm/vec3.hpp>
#include <vector>

#include "formats/environment.h"

namespace lightcook::verify {

struct AxialGradient {
    std::vector<glm::vec3> gradient;  ///< zones of equal solid angle, from the axis to its opposite
    glm::dvec3 uncertainty{0};        ///< what a zone may be off by, by channel: twice the largest difference to half as many lines
    double asymmetricEnergy = 0;      ///< share of the squared radiance over the sphere that the averages have not
};

/// Mean radiance of each zone. axis: any length but 0. Lines run along rows of texels, exactly cut; across rows their count decides.
AxialGradient axialGradient(const formats::Environment& environment, const glm::dvec3& axis, int zoneCount);

}  // namespace lightcook::verify
