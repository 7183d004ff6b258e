// Radiometric quantities as types, and the constants that turn one into another (docs/theory/lighting.md, "Radiometric units").
#pragma once

#include <glm/vec3.hpp>
#include <numbers>

#include "lighting/sh.h"

namespace lightcook::lighting {

template <class Quantity>
struct Rgb {
    glm::vec3 value;  ///< scene-linear, working primaries
    friend Rgb operator+(Rgb a, Rgb b) { return {a.value + b.value}; }
    friend Rgb operator*(float k, Rgb a) { return {k * a.value}; }
};
using Radiance = Rgb<struct RadianceTag>;          ///< [W / (sr m^2)], relative unless the file is calibrated
using Irradiance = Rgb<struct IrradianceTag>;      ///< [W / m^2]
using ExitRadiance = Rgb<struct ExitRadianceTag>;  ///< [W / (sr m^2)] leaving a surface
using GameLight = Rgb<struct GameLightTag>;        ///< colour of a white Lambert surface that faces the light

/// Floor of local relative errors: |error| / (|reference| + kLocalErrorFloor key), where the key is the log-average luminance of the exit
/// radiance. Without it an error in black would count as infinite. docs/theory/error.md, "local error".
inline constexpr double kLocalErrorFloor = 0.02;

/// Zonal factors of the clamped cosine: irradiance, and exit radiance of a white surface (divided by pi).
inline constexpr ShBands kIrradianceBands = {std::numbers::pi, 2 * std::numbers::pi / 3, std::numbers::pi / 4};
inline constexpr ShBands kExitRadianceBands = {1.0, 2.0 / 3.0, 1.0 / 4.0};

/// Returns the exit-radiance factors of energy-conserving wrapped Lambert, [1, (2 - w) / 3, (1 - w)^2 / 4], for w in [0, 1].
ShBands wrappedLambertBands(double wrap);

/// Returns the irradiance E(n) of incident radiance in SH; n is unit.
Irradiance irradiance(const ShRgb& incident, const glm::vec3& normal);
/// Returns albedo / pi * E(n).
ExitRadiance lambertExitRadiance(const ShRgb& incident, const glm::vec3& normal, const glm::vec3& albedo);

enum class GameLightNormalization {
    None,  ///< a light of 1 that faces a white surface gives 17/16: nine coefficients truncate its series
    D3dx   ///< scaled by 16/17, so that it gives exactly 1 (as D3DXSHEvalDirectionalLight)
};
/// Returns a punctual game light of colour c as incident radiance in SH: the radiometric delta pi * c.
/// direction  towards the light, unit
ShRgb projectGameLight(GameLight light, const glm::vec3& direction, GameLightNormalization normalization);

}  // namespace lightcook::lighting
