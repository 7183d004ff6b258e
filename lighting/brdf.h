// BRDF models in their radiometric form: Lambert, Cook-Torrance (Beckmann, GGX), Phong. All directions are unit and point away from the
// surface. Sources: Chen and Liu, Lighting and Material of Halo 3, eq. 6 and Listing 2, with the errata of lighting-math section 4.
#pragma once

#include <glm/vec3.hpp>

#include "lighting/sh.h"

namespace lightcook::lighting {

/// Which constant Cook-Torrance carries. Energy: D normalised by pi, D G F / (4 NoL NoV). Halo3: the listing's, four times as bright.
enum class CookTorranceNormalization { Energy, Halo3 };
enum class NormalDistribution { Beckmann, Ggx };

/// Schlick's Fresnel: f0 + (1 - f0) (1 - LoH)^5.
double schlick(double f0, double LoH);
/// Microfacet distribution [1/sr], integral of D cos over the hemisphere is 1. m is Beckmann's roughness, or GGX's alpha; m > 0.
double distributionBeckmann(double NoH, double m);
double distributionGgx(double NoH, double alpha);
/// Cook and Torrance's geometric attenuation: min(1, 2 NoH NoV / VoH, 2 NoH NoL / VoH).
double attenuationCookTorrance(double NoH, double NoV, double NoL, double VoH);

/// F D G / (4 NoL NoV) [1/sr] (Energy), or four times that (Halo3). Zero below the horizon.
double cookTorrance(const glm::dvec3& view, const glm::dvec3& light, const glm::dvec3& normal, double m, double f0,
                    NormalDistribution distribution, CookTorranceNormalization normalization);

/// Normalised Phong lobe around a reflection vector, cosine power s: radiometric (s + 1) / 2pi, for game lights (s + 1) / 2.
double phongLobe(double RoL, double exponent);
double phongLobeGame(double RoL, double exponent);
/// Appendix B's lobe exp(-tan^2 a / m^2) / (pi m^2 cos^3 a), over the hemisphere around the reflection vector. Zero behind it.
double phongBeckmannLobe(double cosAlpha, double m);

/// The split of area specular in the frame whose z is the normal and whose x-z plane holds the view: reflected radiance is
/// sum_i lambda_i (f0 C_i + (1 - f0) D_i). Coefficients 1, 4, 5 vanish by symmetry.
struct AreaSpecularKernel {
    ShDouble c{};  ///< integral of R_m NoL Y_i
    ShDouble d{};  ///< the same with (1 - LoH)^5
};
/// Integrates by the half vector, Beckmann or GGX importance, sampleCount x sampleCount midpoints over both halves of phi. NoV in [0, 1].
/// 512 samples are within 1e-6 of 4096 for NoV >= 0.05 and m in [0.001, 1], within 3e-4 at NoV = 0.001, where shadowing ends in a fold
/// narrower than a sample.
AreaSpecularKernel integrateAreaSpecular(double NoV, double m, NormalDistribution distribution, CookTorranceNormalization normalization,
                                         int sampleCount);

}  // namespace lightcook::lighting
