#include "verify/assets/lut_derivative.h"

#include <glm/geometric.hpp>
#include <limits>

namespace lightcook::verify::lut {
namespace {

/// |Y_l|: no function of band l exceeds it, and each derivative along a rotation adds a factor l.
constexpr std::array<double, 3> kBandNorm = {0.28209479177387814, 0.48860251190291992, 0.63078313050504001};

double fifthPower(double x) {
    return x * x * x * x * x;
}

/// Intervals of w = max(0, min(u, 2, 4 c u - 2)) and of dw/dtheta over a box.
struct Attenuation {
    Interval value, slope;
};
Attenuation attenuationOver(const HalfVectorBox& box) {
    const Interval cosine = {std::cos(box.phi1), std::cos(box.phi0)};
    const Interval radius = {std::tan(box.psi0), std::tan(box.psi1)}, tangent = {std::tan(box.theta0), std::tan(box.theta1)};
    const Interval c = {std::pow(std::cos(box.psi1), 2), std::pow(std::cos(box.psi0), 2)};
    const Interval p = radius * cosine, excess = p * tangent;
    const Interval u = {1 + excess.low, 1 + excess.high};
    const auto w = [](double at, double squared) { return std::max(0.0, std::min({at, 2.0, 4 * squared * at - 2})); };
    Attenuation result{{w(u.low, u.low > 0 ? c.low : c.high), w(u.high, c.high)}, {}};

    // For each line that may be the smallest, and in [0, 2], somewhere in the box: its slope, and its slope times u - 1.
    const Interval active = intersectionOf(u, {1 / (2 * c.high), std::max(2.0, 1 / c.low)});
    if (active.low > active.high) return result;
    constexpr double kNone = std::numeric_limits<double>::infinity();
    Interval line = {kNone, -kNone}, moment = line;
    const auto include = [&](const Interval& slope, const Interval& product) {
        line = {std::min(line.low, slope.low), std::max(line.high, slope.high)};
        moment = {std::min(moment.low, product.low), std::max(moment.high, product.high)};
    };
    if (u.low <= 1 / (2 * c.low) || u.high >= 2) include({0, 0}, {0, 0});
    if (u.low <= 2 && (4 * c.high - 1) * u.high >= 2) include({1, 1}, {active.low - 1, std::min(active.high, 2.0) - 1});
    if ((4 * c.low - 1) * active.low <= 2 && 4 * c.low * active.low <= 4) {
        // 4 c u is in [2, 4] where this line is active.
        const Interval steep = {4 * c.low, 4 * c.high};
        include(steep, intersectionOf(steep * Interval{active.low - 1, active.high - 1}, {2 - 4 * c.high, 4 - 4 * c.low}));
    }
    if (line.low > line.high) return result;
    // du/dtheta = p / cos^2(theta) = (u - 1) / (sin cos). The first form is tight near the normal, the second towards grazing views.
    const Interval secant = {1 + tangent.low * tangent.low, 1 + tangent.high * tangent.high};
    result.slope = line * (p * secant);
    if (tangent.low > 0) {
        const double s0 = secant.low / tangent.low, s1 = secant.high / tangent.high;  // 1 / (sin cos), smallest at 45 degrees
        const double least = tangent.low < 1 && tangent.high > 1 ? 2 : std::min(s0, s1);
        const Interval tighter = intersectionOf(result.slope, moment * Interval{least, std::max(s0, s1)});
        if (tighter.low <= tighter.high) result.slope = tighter;
    }
    return result;
}

}  // namespace

void addDerivative(const HalfVectorBox& box, EntryIntervals& sums) {
    const Attenuation w = attenuationOver(box);
    if (w.value.high == 0 && w.slope.largest() == 0) return;
    const double theta = (box.theta0 + box.theta1) / 2, psi = (box.psi0 + box.psi1) / 2, phi = (box.phi0 + box.phi1) / 2;
    const glm::dvec3 half(std::sin(psi) * std::cos(phi), std::sin(psi) * std::sin(phi), std::cos(psi));
    const glm::dvec3 view(std::sin(theta), 0, std::cos(theta)), turning(std::cos(theta), 0, -std::sin(theta));
    const double VoH = glm::dot(view, half), VoHSlope = glm::dot(turning, half);
    const glm::dvec3 light = 2 * VoH * half - view, motion = 2 * VoHSlope * half - turning;
    const lighting::ShDouble basis = lighting::evaluateBasis(light);
    // Derivatives of Y_i along the motion of the light.
    const double x = light.x, y = light.y, z = light.z, dx = motion.x, dy = motion.y, dz = motion.z;
    const std::array<double, 6> slopes = {0,
                                          lighting::kShLinear * dz,
                                          lighting::kShLinear * dx,
                                          6 * lighting::kShZonal * z * dz,
                                          lighting::kShProduct * (x * dz + z * dx),
                                          2 * lighting::kShDifference * (x * dx - y * dy)};
    const double moved = box.viewRadius() + 2 * box.halfRadius(), nearer = box.viewRadius() + box.halfRadius();
    const Interval v = {std::clamp(VoH - nearer, 0.0, 1.0), std::clamp(VoH + nearer, 0.0, 1.0)};
    const Interval fresnel = {fifthPower(1 - v.high), fifthPower(1 - v.low)};
    const Interval steep = {-5 * std::pow(1 - v.low, 4), -5 * std::pow(1 - v.high, 4)};
    const Interval fresnelSlope = steep * intersectionOf(Interval::around(VoHSlope, nearer), {-1, 1});
    for (std::size_t i = 0; i < kKernelCoefficients.size(); ++i) {
        const int band = lighting::kShBand[kKernelCoefficients[i]];
        const double norm = kBandNorm[static_cast<std::size_t>(band)];
        const Interval value = intersectionOf(Interval::around(basis[kKernelCoefficients[i]], band * norm * moved), {-norm, norm});
        const Interval slope = intersectionOf(Interval::around(slopes[i], band * band * norm * moved), {-band * norm, band * norm});
        sums[kEntryOfC[i]] = sums[kEntryOfC[i]] + w.slope * value + w.value * slope;
        sums[kEntryOfD[i]] = sums[kEntryOfD[i]] + w.slope * (value * fresnel) + w.value * (slope * fresnel + value * fresnelSlope);
    }
}

EntryIntervals phongDerivative(double theta0, double theta1, const lighting::ShBands& bands) {
    const double theta = (theta0 + theta1) / 2, radius = (theta1 - theta0) / 2;
    const double s = std::sin(theta), c = std::cos(theta);
    const std::array<double, 6> values = {lighting::kShConstant,         lighting::kShLinear * c,
                                          -lighting::kShLinear * s,      lighting::kShZonal * (3 * c * c - 1),
                                          -lighting::kShProduct * s * c, lighting::kShDifference * s * s};
    const std::array<double, 6> slopes = {0,
                                          -lighting::kShLinear * s,
                                          -lighting::kShLinear * c,
                                          -6 * lighting::kShZonal * s * c,
                                          -lighting::kShProduct * (c * c - s * s),
                                          2 * lighting::kShDifference * s * c};
    const Interval v = {std::cos(theta1), std::cos(theta0)};
    const Interval schlick = {fifthPower(1 - v.high), fifthPower(1 - v.low)};
    const Interval schlickSlope =
        Interval{5 * std::pow(1 - v.high, 4), 5 * std::pow(1 - v.low, 4)} * Interval{std::sin(theta0), std::sin(theta1)};
    EntryIntervals derivative;
    for (std::size_t i = 0; i < values.size(); ++i) {
        const int band = lighting::kShBand[kKernelCoefficients[i]];
        const double factor = bands[static_cast<std::size_t>(band)], norm = kBandNorm[static_cast<std::size_t>(band)];
        const Interval value = Interval::around(values[i], band * norm * radius) * Interval{factor, factor};
        const Interval slope = Interval::around(slopes[i], band * band * norm * radius) * Interval{factor, factor};
        derivative[kEntryOfC[i]] = slope;
        derivative[kEntryOfD[i]] = slope * schlick + value * schlickSlope;
    }
    return derivative;
}

}  // namespace lightcook::verify::lut
