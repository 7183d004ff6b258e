// The dominant light's specular light by the shader source of a scene's lobe. Private to verify/.
#pragma once

#include "lighting/brdf.h"
#include "shaders/lightcook_ggx.h"

namespace lightcook::verify {

/// Calls lcDominantSpecular as the include of a scene with this lobe has it.
inline glm::vec3 dominantSpecular(lighting::NormalDistribution lobe, const glm::vec3& view, const glm::vec3& direction,
                                  const glm::vec3& intensity, const glm::vec3& normal, float m, const glm::vec3& f0) {
    return lobe == lighting::NormalDistribution::Ggx ? shaders::ggx::lcDominantSpecular(view, direction, intensity, normal, m, f0)
                                                     : shaders::lcDominantSpecular(view, direction, intensity, normal, m, f0);
}

}  // namespace lightcook::verify
