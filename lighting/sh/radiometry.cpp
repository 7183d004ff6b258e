#include "lighting/radiometry.h"

#include <cassert>

namespace lightcook::lighting {

ShBands wrappedLambertBands(double wrap) {
    assert(0 <= wrap && wrap <= 1);
    return {1.0, (2 - wrap) / 3, (1 - wrap) * (1 - wrap) / 4};
}

Irradiance irradiance(const ShRgb& incident, const glm::vec3& normal) {
    return {evaluate(convolve(incident, kIrradianceBands), normal)};
}

ExitRadiance lambertExitRadiance(const ShRgb& incident, const glm::vec3& normal, const glm::vec3& albedo) {
    return {albedo * evaluate(convolve(incident, kExitRadianceBands), normal)};
}

ShRgb projectGameLight(GameLight light, const glm::vec3& direction, GameLightNormalization normalization) {
    // With nine coefficients a light of 1 gives sum_l A_l (2l + 1) / 4pi = 1/4 + 1/2 + 5/16 = 17/16.
    const float scale = normalization == GameLightNormalization::D3dx ? 16.0f / 17.0f : 1.0f;
    return projectDirectional(direction, std::numbers::pi_v<float> * scale * light.value);
}

}  // namespace lightcook::lighting
