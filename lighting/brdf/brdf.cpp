#include "lighting/brdf.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/geometric.hpp>
#include <numbers>
#include <vector>

namespace lightcook::lighting {

namespace {

using std::numbers::pi;

/// Smaller cosines count as under the horizon: opposite grazing directions give 1 / (NoL NoV), which must not overflow, and a
/// half vector whose squared length must not underflow.
constexpr double kHorizonCosine = 1e-30;

double normalizationScale(CookTorranceNormalization normalization) {
    // Listing 2 has a D without 1 / pi, and eq. 6 divides by pi: D G / (pi NoL NoV). That is four times (D / pi) G / (4 NoL NoV).
    return normalization == CookTorranceNormalization::Halo3 ? 4.0 : 1.0;
}

/// Returns tan^2 of the half vector's polar angle at which the cumulative D cos is u. `rest` is 1 - u, passed separately to keep its
/// digits.
double squaredTangentAt(double u, double rest, double m, NormalDistribution distribution) {
    return distribution == NormalDistribution::Beckmann ? -m * m * (u < 0.5 ? std::log1p(-u) : std::log(rest)) : m * m * u / rest;
}

/// Returns a monotone map of [0, 1] onto itself with derivative 140 s^3 (1 - s)^3, and rising(s) + rising(1 - s) = 1.
double rising(double s) {
    const double s2 = s * s;
    return s2 * s2 * (35 + s * (-84 + s * (70 - 20 * s)));
}

/// Sums of weight * {1, z, x, z^2, xz, x^2}, from which the six coefficients that do not vanish follow.
struct Moments {
    double one = 0, z = 0, x = 0, zz = 0, xz = 0, xx = 0;

    void add(double weight, double lightX, double lightZ) {
        const double weightX = weight * lightX, weightZ = weight * lightZ;
        one += weight;
        z += weightZ;
        x += weightX;
        zz += weightZ * lightZ;
        xz += weightX * lightZ;
        xx += weightX * lightX;
    }
    void add(double weight, const Moments& other) {
        one += weight * other.one;
        z += weight * other.z;
        x += weight * other.x;
        zz += weight * other.zz;
        xz += weight * other.xz;
        xx += weight * other.xx;
    }
    ShDouble coefficients() const {
        // x^2 - y^2 = 2 x^2 + z^2 - 1 on the sphere.
        return {kShConstant * one,
                0,
                kShLinear * z,
                kShLinear * x,
                0,
                0,
                kShZonal * (3 * zz - one),
                kShProduct * xz,
                kShDifference * (2 * xx + zz - one)};
    }
};

}  // namespace

double schlick(double f0, double LoH) {
    return f0 + (1 - f0) * fifthPower(1 - LoH);
}

double distributionBeckmann(double NoH, double m) {
    assert(m > 0);
    if (NoH <= 0) return 0;
    const double squaredCosine = NoH * NoH;
    const double squaredTangent = std::max(0.0, (1 - NoH) * (1 + NoH)) / squaredCosine;
    const double lobe = std::exp(-squaredTangent / (m * m));
    return lobe == 0 ? 0 : lobe / (pi * m * m * squaredCosine * squaredCosine);
}

double distributionGgx(double NoH, double alpha) {
    assert(alpha > 0);
    if (NoH <= 0) return 0;
    const double denominator = std::max(0.0, (1 - NoH) * (1 + NoH)) + NoH * NoH * alpha * alpha;
    return alpha * alpha / (pi * denominator * denominator);
}

double attenuationCookTorrance(double NoH, double NoV, double NoL, double VoH) {
    return std::min(1.0, 2 * NoH * std::min(NoV, NoL) / VoH);
}

double cookTorrance(const glm::dvec3& view, const glm::dvec3& light, const glm::dvec3& normal, double m, double f0,
                    NormalDistribution distribution, CookTorranceNormalization normalization) {
    const double NoV = glm::dot(normal, view), NoL = glm::dot(normal, light);
    if (NoV <= kHorizonCosine || NoL <= kHorizonCosine) return 0;
    const glm::dvec3 half = glm::normalize(view + light);
    const double NoH = std::min(1.0, glm::dot(normal, half)), VoH = std::clamp(glm::dot(view, half), 0.0, 1.0);
    if (NoH <= 0 || VoH <= 0) return 0;
    const double D = distribution == NormalDistribution::Beckmann ? distributionBeckmann(NoH, m) : distributionGgx(NoH, m);
    // G / (NoL NoV), with the smaller cosine cancelled before it can divide by almost nothing.
    const double visibility = std::min(1 / std::min(NoV, NoL), 2 * NoH / VoH) / std::max(NoV, NoL);
    return normalizationScale(normalization) * schlick(f0, VoH) * D * visibility / 4;
}

double phongLobe(double RoL, double exponent) {
    return RoL <= 0 ? 0 : (exponent + 1) / (2 * pi) * std::pow(RoL, exponent);
}

double phongLobeGame(double RoL, double exponent) {
    return RoL <= 0 ? 0 : (exponent + 1) / 2 * std::pow(RoL, exponent);
}

double phongBeckmannLobe(double cosAlpha, double m) {
    assert(m > 0);
    if (cosAlpha <= 0) return 0;
    const double squaredTangent = std::max(0.0, (1 - cosAlpha) * (1 + cosAlpha)) / (cosAlpha * cosAlpha);
    const double lobe = std::exp(-squaredTangent / (m * m));
    return lobe == 0 ? 0 : lobe / (pi * m * m * cosAlpha * cosAlpha * cosAlpha);
}

AreaSpecularKernel integrateAreaSpecular(double NoV, double m, NormalDistribution distribution, CookTorranceNormalization normalization,
                                         int sampleCount) {
    assert(0 <= NoV && NoV <= 1 && m > 0 && sampleCount > 0);
    const double viewZ = std::max(NoV, 1e-9);  // the limit at the horizon is finite, the quotient 0 / 0 is not
    const double viewX = std::sqrt(std::max(0.0, 1 - viewZ * viewZ));

    // The two halves of phi mirror each other; with an odd count the middle sample is its own mirror image.
    const int phiCount = (sampleCount + 1) / 2;
    std::vector<double> cosPhi(static_cast<std::size_t>(phiCount));
    for (int i = 0; i < phiCount; ++i) cosPhi[static_cast<std::size_t>(i)] = std::cos(2 * pi * (i + 0.5) / sampleCount);
    const double lastWeight = sampleCount % 2 == 1 ? 0.5 : 1;

    Moments c, d;
    for (int row = 0; row < sampleCount; ++row) {
        // Midpoints in s, not in u: u's density of tan^2 ends in a logarithm (Beckmann) or a pole (GGX), where plain midpoints
        // err by 0.35 m^2 / sampleCount. With the flat ends of `rising` the Euler-Maclaurin ends vanish up to the fourth order.
        const double s = (row + 0.5) / sampleCount;
        const double rowWeight = 140 * s * s * s * (1 - s) * (1 - s) * (1 - s);
        const double NoH = 1 / std::sqrt(1 + squaredTangentAt(rising(s), rising(1 - s), m, distribution));
        const double sinH = std::sqrt(std::max(0.0, (1 - NoH) * (1 + NoH)));
        Moments rowC, rowD;
        for (int i = 0; i < phiCount; ++i) {
            const double halfX = sinH * cosPhi[static_cast<std::size_t>(i)];
            const double VoH = halfX * viewX + NoH * viewZ;
            const double NoL = 2 * VoH * NoH - viewZ;
            if (VoH <= 0 || NoL <= 0) continue;
            // D G cos / (4 NoL NoV) over the density D NoH / (4 VoH) of the light: G VoH / (NoV NoH), with G's VoH cancelled.
            double weight = std::min(VoH, 2 * NoH * std::min(viewZ, NoL)) / (viewZ * NoH);
            if (i == phiCount - 1) weight *= lastWeight;
            const double lightX = 2 * VoH * halfX - viewX;
            rowC.add(weight, lightX, NoL);
            rowD.add(weight * fifthPower(1 - std::min(VoH, 1.0)), lightX, NoL);
        }
        c.add(rowWeight, rowC);
        d.add(rowWeight, rowD);
    }
    const double scale = normalizationScale(normalization) * 2 / (static_cast<double>(sampleCount) * sampleCount);
    Moments scaledC, scaledD;
    scaledC.add(scale, c);
    scaledD.add(scale, d);
    return {scaledC.coefficients(), scaledD.coefficients()};
}

}  // namespace lightcook::lighting
