// The area-specular kernel C and D (brdf.h) of Cook-Torrance and Phong lobes, to about 1e-7.
//
// Method: the azimuth of the half vector is integrated in closed form. The remaining integral over its polar angle is cut where
// the attenuation of Cook and Torrance changes its case. The integrand is smooth inside each piece, so Gauss points converge to rounding.
// docs/theory/lighting.md, "Specular tables", has the definitions.
#pragma once

#include <array>
#include <vector>

#include "lighting/brdf.h"

namespace lightcook::lighting {

/// The lobes of a table of C and D. The two Phong lobes lie around the reflected view (Chen and Liu, appendix B) and are not cut at the
/// surface's horizon: C_i = k_l Y_i(reflection). Appendix B has no Fresnel term; D is C times Schlick's (1 - NoV)^5, the value at the
/// lobe's centre.
enum class SpecularLobe {
    Beckmann,   ///< Cook-Torrance
    Ggx,        ///< Cook-Torrance; m is alpha
    Phong,      ///< exp(-tan^2 a / m^2) / (pi m^2 cos^3 a) around the reflection, whose integral is 1
    PhongPower  ///< (s + 1) / 2pi cos^s a, s = 2 / m^2 - 2
};

/// Returns the zonal factors k_l of a Phong lobe for bands 0, 1, 2. 1e-4 <= m <= 1.
ShBands phongBands(SpecularLobe lobe, double m);

/// Precomputed integrals of one view, from which the kernel of any m follows.
///
/// With tangents p, q of the half vector (p towards the view), c = NoH^2 and u = VoH / (NoH NoV) = 1 + p tan(theta_v), the integrand is the
/// density of slopes times w Y_i(l), w = max(0, min(u, 2, 4 c u - 2)). On a circle of slopes u is linear in cos(phi). So w is piecewise
/// linear with breaks at no more than three closed-form azimuths, and the other factors are a polynomial of degree 10 in cos(phi): the
/// integral is a sum of moments of cos^k. The circles on which a break appears are closed forms, too.
class AreaSpecularColumn {
public:
    /// NoV                    in [0, 1]; smaller than 1e-9 counts as 1e-9, where the limit is reached to rounding
    /// smallestM, largestM   range of m for kernel(), within [1e-4, 1]
    /// pointCount            Gauss points a piece, 2 to 32
    AreaSpecularColumn(double NoV, double smallestM, double largestM, SpecularLobe lobe, int pointCount = kDefaultPoints);
    AreaSpecularKernel kernel(double m, CookTorranceNormalization normalization) const;

    static constexpr int kDefaultPoints = 16;

private:
    /// Integrals over the azimuth of one circle of slopes: of C and of D, each times {1, z, x, z^2, xz, x^2} of the light direction.
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

/// Returns the kernel of one view and m. Error: at most 1e-7 of the largest entry against an adaptive reference in long double, for m from
/// 1e-4 to 1 and every view; 16 and 32 points differ by less than 1e-8.
AreaSpecularKernel areaSpecular(double NoV, double m, SpecularLobe lobe, CookTorranceNormalization normalization,
                                int pointCount = AreaSpecularColumn::kDefaultPoints);

}  // namespace lightcook::lighting
