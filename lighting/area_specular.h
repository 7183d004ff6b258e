// The area-specular kernel C and D with the azimuth of the half vector integrated in closed form. What is left is one integral over its
// polar angle, cut where Cook and Torrance's attenuation changes its case, so that Gauss points converge to rounding.
#pragma once

#include <array>
#include <vector>

#include "lighting/brdf.h"

namespace lightcook::lighting {

/// What a table of C and D can hold. The two Phong lobes lie around the reflected view (Chen and Liu, appendix B) and are not cut at the
/// surface's horizon: C_i = k_l Y_i(reflection). Appendix B has no Fresnel; D is C times Schlick's (1 - NoV)^5, that of the lobe's middle.
enum class SpecularLobe {
    Beckmann,   ///< Cook-Torrance
    Ggx,        ///< Cook-Torrance; m is alpha
    Phong,      ///< exp(-tan^2 a / m^2) / (pi m^2 cos^3 a) around the reflection, whose integral is 1
    PhongPower  ///< (s + 1) / 2pi cos^s a, s = 2 / m^2 - 2
};

/// The factors of bands 0, 1, 2 of the two Phong lobes. 1e-4 <= m <= 1.
ShBands phongBands(SpecularLobe lobe, double m);

/// Everything about one view that does not depend on m. NoV in [0, 1]; below 1e-9 it is evaluated there, where the limit is reached to
/// rounding. smallestM and largestM, 1e-4 to 1: the range of m that kernel() will be asked for.
///
/// With tangents p, q of the half vector (p towards the view), c = NoH^2 and u = VoH / (NoH NoV) = 1 + p tan(theta_v), the integrand is the
/// density of slopes times w Y_i(l), w = max(0, min(u, 2, 4 c u - 2)). On a circle of slopes u is linear in cos(phi), so w is linear
/// between at most three closed-form azimuths and the rest a polynomial of degree 10: moments of cos^k. The circles on which such an
/// azimuth appears are closed forms too.
class AreaSpecularColumn {
public:
    /// pointCount: Gauss points a piece, 2 to 32.
    AreaSpecularColumn(double NoV, double smallestM, double largestM, SpecularLobe lobe, int pointCount = kDefaultPoints);
    AreaSpecularKernel kernel(double m, CookTorranceNormalization normalization) const;

    static constexpr int kDefaultPoints = 16;

private:
    /// Twelve integrals over the azimuth of one circle of slopes: C and D by {1, z, x, z^2, xz, x^2} of the light.
    struct Circle {
        double psi, squaredTangent, weight;  ///< of the Gauss rule over psi, with d(tan^2 psi) / d psi
        std::array<double, 12> moments;
    };
    void addPiece(double low, double high, int pointCount);
    Circle circleAt(double psi) const;

    SpecularLobe lobe_;
    double NoV_, sine_;
    std::vector<Circle> circles_;
};

/// One kernel of any lobe. Within 1e-7 of its largest entry of an adaptive reference in long double, m from 1e-4 to 1, every view; 16 and
/// 32 points differ by less than 1e-8.
AreaSpecularKernel areaSpecular(double NoV, double m, SpecularLobe lobe, CookTorranceNormalization normalization,
                                int pointCount = AreaSpecularColumn::kDefaultPoints);

}  // namespace lightcook::lighting
