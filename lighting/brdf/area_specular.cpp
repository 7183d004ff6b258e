#include "lighting/area_specular.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

namespace lightcook::lighting {
namespace {

using std::numbers::pi;
constexpr double kSmallestNoV = 1e-9;
/// Limit of the slopes over m: exp(-6.5^2) = 4e-19.
constexpr double kBeckmannReach = 6.5;
/// Largest ratio of the ends of a piece of the polar angle, so that kinks outside the piece are far from it.
constexpr double kPieceRatio = 4;
constexpr int kHighestPower = 10;
/// Arcs narrower than this are integrated by Gauss points: differences of antiderivatives would cancel. Near grazing views, where u is
/// steep, all relevant arcs are narrow.
constexpr double kNarrowArc = 0.1;
constexpr int kNarrowPoints = 6;

struct GaussRule {
    std::vector<double> points, weights;  ///< on [0, 1]
};

/// Computes the roots of the Legendre polynomial by Newton from Chebyshev's estimate.
GaussRule gaussRule(int count) {
    GaussRule rule;
    for (int i = 0; i < count; ++i) {
        double x = std::cos(pi * (i + 0.75) / (count + 0.5)), slope = 1;
        for (int step = 0; step < 100; ++step) {
            double previous = 1, value = x;
            for (int k = 2; k <= count; ++k) {
                const double next = ((2 * k - 1) * x * value - (k - 1) * previous) / k;
                previous = value;
                value = next;
            }
            slope = count * (x * value - previous) / (x * x - 1);
            const double change = value / slope;
            x -= change;
            if (std::abs(change) < 1e-15) break;
        }
        rule.points.push_back((1 - x) / 2);
        rule.weights.push_back(1 / ((1 - x * x) * slope * slope));
    }
    return rule;
}

const GaussRule& gaussRuleOf(int count) {
    static const std::array<GaussRule, 33> kRules = [] {
        std::array<GaussRule, 33> rules;
        for (int i = 2; i <= 32; ++i) rules[static_cast<std::size_t>(i)] = gaussRule(i);
        return rules;
    }();
    return kRules[static_cast<std::size_t>(count)];
}

using Powers = std::array<double, kHighestPower + 1>;

/// Returns the antiderivatives of cos^k(phi) for k = 0 to 10.
Powers powersAt(double phi, double cosine) {
    Powers integrals;
    const double sine = std::sqrt(std::max(0.0, (1 - cosine) * (1 + cosine)));
    integrals[0] = phi;
    integrals[1] = sine;
    double power = cosine;  // cos^(k - 1)
    for (std::size_t k = 2; k < integrals.size(); ++k) {
        integrals[k] = (power * sine + static_cast<double>(k - 1) * integrals[k - 2]) / static_cast<double>(k);
        power *= cosine;
    }
    return integrals;
}

/// Returns the integrals of w cos^k over half the azimuth, k = 0 to 9, for u = 1 + a cos(phi) and c = NoH^2: over each azimuth range in
/// which w is linear in u (AreaSpecularColumn), by antiderivatives, or by Gauss points where the range is narrow.
std::array<double, kHighestPower> weightedPowers(double a, double c, double squaredTangent) {
    // From phi = 0, where u is largest, down to the horizon of the light: w = constant + slope * u, up to the next azimuth.
    struct Case {
        double lowestU, constant, slope;
    };
    const double horizon = (1 + squaredTangent) / 2;
    std::array<Case, 3> cases;
    std::size_t count = 0;
    if (squaredTangent <= 1) {
        cases[count++] = {2, 2, 0};
        cases[count++] = {2 * (1 + squaredTangent) / (3 - squaredTangent), 0, 1};
    } else {
        cases[count++] = {1 + squaredTangent, 2, 0};
    }
    cases[count++] = {horizon, -2, 4 * c};

    std::array<double, kHighestPower> sums{};
    Powers from = powersAt(0, 1);
    double fromCosine = 1;
    const GaussRule& narrow = gaussRuleOf(kNarrowPoints);
    for (std::size_t i = 0; i < count; ++i) {
        const double excess = cases[i].lowestU - 1;
        const double cosine = excess >= a * fromCosine ? fromCosine : excess <= -a ? -1 : excess / a;
        if (cosine >= fromCosine) continue;
        const Powers to = powersAt(std::acos(cosine), cosine);
        const double constant = cases[i].constant + cases[i].slope, slope = cases[i].slope * a;
        if (const double width = to[0] - from[0]; width < kNarrowArc) {
            for (std::size_t point = 0; point < narrow.points.size(); ++point) {
                const double x = std::cos(from[0] + width * narrow.points[point]);
                double weight = width * narrow.weights[point] * (constant + slope * x);
                for (double& sum : sums) {
                    sum += weight;
                    weight *= x;
                }
            }
        } else {
            for (std::size_t k = 0; k < sums.size(); ++k) sums[k] += constant * (to[k] - from[k]) + slope * (to[k + 1] - from[k + 1]);
        }
        from = to;
        fromCosine = cosine;
        if (cosine == -1) break;
    }
    return sums;
}

/// Returns the density of tan^2 of the half vector's polar angle.
double densityOf(double squaredTangent, double m, SpecularLobe lobe) {
    const double m2 = m * m;
    if (lobe == SpecularLobe::Beckmann) return std::exp(-squaredTangent / m2) / m2;
    const double root = m2 + squaredTangent;
    return m2 / (root * root);
}

/// Returns coefficients from the integrals of {1, z, x, z^2, xz, x^2}: x^2 - y^2 = 2 x^2 + z^2 - 1 on the sphere.
ShDouble coefficientsOf(const double* moments) {
    return {kShConstant * moments[0],
            0,
            kShLinear * moments[1],
            kShLinear * moments[2],
            0,
            0,
            kShZonal * (3 * moments[3] - moments[0]),
            kShProduct * moments[4],
            kShDifference * (2 * moments[5] + moments[3] - moments[0])};
}

bool isPhong(SpecularLobe lobe) {
    return lobe == SpecularLobe::Phong || lobe == SpecularLobe::PhongPower;
}

AreaSpecularKernel phongKernel(double NoV, double m, SpecularLobe lobe) {
    const ShBands bands = phongBands(lobe, m);
    const ShDouble basis = evaluateBasis(glm::dvec3(-std::sqrt(std::max(0.0, (1 - NoV) * (1 + NoV))), 0, NoV));
    const double schlick = fifthPower(1 - NoV);
    AreaSpecularKernel kernel;
    for (std::size_t i = 0; i < basis.size(); ++i) {
        if (i == 1 || i == 4 || i == 5) continue;  // zero by symmetry, and without a sign
        kernel.c[i] = bands[static_cast<std::size_t>(kShBand[i])] * basis[i];
        kernel.d[i] = schlick * kernel.c[i];
    }
    return kernel;
}

}  // namespace

ShBands phongBands(SpecularLobe lobe, double m) {
    assert(isPhong(lobe) && m > 0);
    if (lobe == SpecularLobe::PhongPower) {
        const double exponent = 2 / (m * m) - 2;
        return {1, (exponent + 1) / (exponent + 2), exponent / (exponent + 3)};
    }
    // cos a = (1 + t^2)^(-1/2), and t^2 / m^2 has the density exp(-x): both means are smooth, and stay so with x = y^2.
    const GaussRule& rule = gaussRuleOf(32);
    double first = 0, second = 0;
    for (int piece = 0; piece < 4; ++piece)
        for (std::size_t i = 0; i < rule.points.size(); ++i) {
            const double y = kBeckmannReach * (piece + rule.points[i]) / 4;
            const double weight = kBeckmannReach / 4 * rule.weights[i] * 2 * y * std::exp(-y * y);
            const double squaredTangent = m * m * y * y, squaredCosine = 1 / (1 + squaredTangent);
            first += weight * std::sqrt(squaredCosine);
            second += weight * 1.5 * squaredTangent * squaredCosine;
        }
    return {1, first, 1 - second};
}

AreaSpecularColumn::AreaSpecularColumn(double NoV, double smallestM, double largestM, SpecularLobe lobe, int pointCount)
    : lobe_(lobe), NoV_(std::clamp(NoV, kSmallestNoV, 1.0)), sine_(std::sqrt((1 - NoV_) * (1 + NoV_))) {
    assert(0 < smallestM && smallestM <= largestM && 2 <= pointCount && pointCount <= 32);
    if (isPhong(lobe)) return;
    // Circles on which a break of weightedPowers appears or vanishes: |u - 1| = tan(psi) tan(theta), by the formulas of half and triple
    // angles.
    const double theta = std::acos(NoV_), rest = std::asin(NoV_), end = (pi / 2 + theta) / 2;
    std::vector<double> ends = {rest / 3, rest / 2, rest, (pi / 2 + theta) / 3, theta, pi / 4, end};
    double reach = pi / 2;
    if (lobe == SpecularLobe::Beckmann) {
        for (const double times : {1.0, 2.2, 4.0}) ends.push_back(std::atan(times * smallestM));
        reach = std::atan(kBeckmannReach * largestM);
    } else {
        ends.push_back(std::atan(0.5 * smallestM));
        ends.push_back(std::atan(2 * smallestM));
    }
    ends.push_back(reach);
    std::erase_if(ends, [&](double psi) { return !(psi > 0) || psi > std::min(reach, end); });
    std::sort(ends.begin(), ends.end());
    double low = 0;
    for (const double high : ends) {
        for (double next = low * kPieceRatio; next > 0 && next < high / 1.5; next *= kPieceRatio) {
            addPiece(low, next, pointCount);
            low = next;
        }
        if (high > low) addPiece(low, high, pointCount);
        low = high;
    }
}

void AreaSpecularColumn::addPiece(double low, double high, int pointCount) {
    const GaussRule& rule = gaussRuleOf(pointCount);
    for (std::size_t i = 0; i < rule.points.size(); ++i) {
        // A break moves as the root of the distance from the end of a piece. Squaring the variable towards both ends makes the integrand
        // smooth.
        const double t = rule.points[i], place = t * t * (3 - 2 * t), slope = 6 * t * (1 - t);
        Circle circle = circleAt(low + (high - low) * place);
        circle.weight = rule.weights[i] * slope * (high - low) * 2 * std::sqrt(circle.squaredTangent) * (1 + circle.squaredTangent) / pi;
        circles_.push_back(circle);
    }
}

AreaSpecularColumn::Circle AreaSpecularColumn::circleAt(double psi) const {
    const double NoH = std::cos(psi), sinH = std::sin(psi), c = NoH * NoH;
    Circle circle{psi, sinH * sinH / c, 0, {}};
    const auto j = weightedPowers(sinH / NoH * sine_ / NoV_, c, circle.squaredTangent);
    // Polynomials of X = cos(phi): VoH, and the light's z (degree 1) and x (degree 2).
    const double v0 = NoH * NoV_, v1 = sinH * sine_;
    const double z0 = 2 * v0 * NoH - NoV_, z1 = 2 * v1 * NoH;
    const double x0 = -sine_, x1 = 2 * v0 * sinH, x2 = 2 * v1 * sinH;
    const auto fill = [&](const double* p, double* out) {
        out[0] = p[0];
        out[1] = z0 * p[0] + z1 * p[1];
        out[2] = x0 * p[0] + x1 * p[1] + x2 * p[2];
        out[3] = z0 * z0 * p[0] + 2 * z0 * z1 * p[1] + z1 * z1 * p[2];
        out[4] = z0 * x0 * p[0] + (z0 * x1 + z1 * x0) * p[1] + (z0 * x2 + z1 * x1) * p[2] + z1 * x2 * p[3];
        out[5] = x0 * x0 * p[0] + 2 * x0 * x1 * p[1] + (x1 * x1 + 2 * x0 * x2) * p[2] + 2 * x1 * x2 * p[3] + x2 * x2 * p[4];
    };
    fill(j.data(), circle.moments.data());
    // (1 - VoH)^5 = (f0 - v1 X)^5.
    const double f0 = 1 - v0, f02 = f0 * f0, v12 = v1 * v1;
    const std::array<double, 6> fresnel = {f02 * f02 * f0,       -5 * f02 * f02 * v1, 10 * f02 * f0 * v12,
                                           -10 * f02 * v12 * v1, 5 * f0 * v12 * v12,  -v12 * v12 * v1};
    std::array<double, 5> reflected{};
    for (std::size_t k = 0; k < reflected.size(); ++k)
        for (std::size_t n = 0; n < fresnel.size(); ++n) reflected[k] += fresnel[n] * j[k + n];
    fill(reflected.data(), circle.moments.data() + 6);
    return circle;
}

AreaSpecularKernel AreaSpecularColumn::kernel(double m, CookTorranceNormalization normalization) const {
    if (isPhong(lobe_)) return phongKernel(NoV_, m, lobe_);
    std::array<double, 12> sums{};
    for (const Circle& circle : circles_) {
        const double weight = circle.weight * densityOf(circle.squaredTangent, m, lobe_);
        for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += weight * circle.moments[i];
    }
    const double scale = normalization == CookTorranceNormalization::Halo3 ? 4 : 1;
    for (double& sum : sums) sum *= scale;
    return {coefficientsOf(sums.data()), coefficientsOf(sums.data() + 6)};
}

AreaSpecularKernel areaSpecular(double NoV, double m, SpecularLobe lobe, CookTorranceNormalization normalization, int pointCount) {
    return AreaSpecularColumn(NoV, m, m, lobe, pointCount).kernel(m, normalization);
}

}  // namespace lightcook::lighting
