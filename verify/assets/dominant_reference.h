// The dominant light that a texel's float coefficients ask for: what the verifier holds cooked textures against, found on its own.
#pragma once

#include <glm/vec3.hpp>

#include "lighting/sh.h"

namespace lightcook::verify {

/// A light as it is meant to be: direction in the unit ball, radiometric delta intensity.
struct DominantLightSample {
    glm::dvec3 direction{0}, intensity{0};
};

/// What the cook says it fitted: the closed form; the best of all directions; the same, dimmed where it leaves much; beside ambient light.
enum class DominantFit { Closed, Refined, Explained, RefinedAmbient };

/// Closed form of Chen and Liu 1.4.1 with lighting-math section 3: v = band 1 / (sqrt(3) lambda_0) of the luminance, inside the unit ball;
/// t = smoothstep(0.02, 0.08, |v|); direction t v + (1 - t) 0.08 n; intensity t (4pi / 9) sum lambda_i Y_i(direction), clamped at 0.
DominantLightSample dominantReference(const lighting::ShRgb& incident, const glm::dvec3& normal, const glm::vec3& luminanceWeights);

/// The same with v turned to the direction whose least squares (intensity and, beside it, ambient light, neither below 0) leaves least of
/// the coefficients. Dense search, then quadratic fits to stencils. Lights that leave the same (within 1e-3 of the root of the squared
/// error over the norm of the coefficients) are equally good: seen, the direction in the textures, decides between them; only its direction
/// counts.
DominantLightSample refinedReference(const lighting::ShRgb& incident, const glm::dvec3& normal, const glm::vec3& luminanceWeights,
                                     bool hasAmbient, const glm::dvec3& seen);

/// The refined light without ambient light, times 1 - smoothstep(0.3, 0.4, r): r is the root of the squared error that a light from its
/// direction leaves at the least, over the norm of the coefficients.
DominantLightSample explainedReference(const lighting::ShRgb& incident, const glm::dvec3& normal, const glm::vec3& luminanceWeights,
                                       const glm::dvec3& seen);

/// Squared error of a light over the squared norm of the coefficients, and both: with ambient light, that of what the light leaves of
/// coefficient 0, if it leaves any.
struct Unexplained {
    double error = 0, energy = 0;
};
Unexplained unexplainedBy(const lighting::ShRgb& incident, const DominantLightSample& light, bool hasAmbient);

}  // namespace lightcook::verify
