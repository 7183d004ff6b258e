// BRDF models in radiometric form: Cook-Torrance (Beckmann, GGX) and Phong. All directions are unit and point away from the surface.
// Sources: Cook and Torrance 1982; Chen and Liu 2008, Lighting and Material of Halo 3, eq. 6 and Listing 2, with the corrections of
// docs/theory/lighting.md, "Specular tables".
#pragma once

#include <glm/vec3.hpp>

#include "lighting/sh.h"

namespace lightcook::lighting {

/// Constant factor of Cook-Torrance.
enum class CookTorranceNormalization {
    Energy,  ///< F D G / (4 NoL NoV) with the integral of D cos equal to 1
    Halo3    ///< as in the listing: four times as bright
};
enum class NormalDistribution { Beckmann, Ggx };

constexpr double fifthPower(double x) {
    return x * x * x * x * x;
}
/// Returns Schlick's Fresnel term f0 + (1 - f0) (1 - LoH)^5.
double schlick(double f0, double LoH);
/// Return the microfacet distribution D [1/sr]; the integral of D cos over the hemisphere is 1. m and alpha are greater than 0.
double distributionBeckmann(double NoH, double m);
double distributionGgx(double NoH, double alpha);
/// Returns the geometric attenuation of Cook and Torrance, min(1, 2 NoH NoV / VoH, 2 NoH NoL / VoH).
double attenuationCookTorrance(double NoH, double NoV, double NoL, double VoH);

/// Returns F D G / (4 NoL NoV) [1/sr] for Energy, four times that for Halo3. Zero below the horizon.
double cookTorrance(const glm::dvec3& view, const glm::dvec3& light, const glm::dvec3& normal, double m, double f0,
                    NormalDistribution distribution, CookTorranceNormalization normalization);

/// Return the Phong lobe RoL^s around a reflection vector times (s + 1) / 2pi (radiometric) or (s + 1) / 2 (for game lights).
double phongLobe(double RoL, double exponent);
double phongLobeGame(double RoL, double exponent);
/// Returns the lobe of Chen and Liu, appendix B, exp(-tan^2 a / m^2) / (pi m^2 cos^3 a), around the reflection vector. Zero for
/// cosAlpha <= 0.
double phongBeckmannLobe(double cosAlpha, double m);

/// Area specular of incident light in SH: reflected radiance = sum_i lambda_i (f0 C_i + (1 - f0) D_i). In the frame whose z is the normal
/// and whose x-z plane holds the view. Coefficients 1, 4, 5 vanish by symmetry.
struct AreaSpecularKernel {
    ShDouble c{};  ///< integral of R_m NoL Y_i
    ShDouble d{};  ///< the same with (1 - LoH)^5
};
/// Integrates the kernel numerically over the half vector, with importance sampling of the distribution by sampleCount x sampleCount
/// midpoints. NoV in [0, 1]. 512 samples differ from 4096 by at most 1e-6 for NoV >= 0.05 and m in [0.001, 1], and by 3e-4 at NoV = 0.001,
/// where the attenuation has a fold narrower than a sample. area_specular.h is more exact and faster; this is its independent check.
AreaSpecularKernel integrateAreaSpecular(double NoV, double m, NormalDistribution distribution, CookTorranceNormalization normalization,
                                         int sampleCount);

}  // namespace lightcook::lighting
