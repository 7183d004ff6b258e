#include "verify/light_map_bound.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <numbers>

#include "lighting/quadratic.h"
#include "lighting/radiometry.h"

namespace verify {

namespace {

/// Dinkelbach's iteration takes four or five steps; rings of light that make a denominator vanish end it by themselves.
constexpr int kMaximumSteps = 32;
/// A denominator below this part of the floor: the reference is negative there, and the other bound serves better.
constexpr double kVanishing = 1e-3;
constexpr double kRelativeSlack = 1e-12;
/// |r| >= share r for any share in [-1, 1]. Light that rings below zero, by less than floor / share, is still bounded by that share of
/// its bright side, instead of by the floor alone (share 0).
constexpr std::array<double, 6> kShares = {1.0, 1.0 / 4, 1.0 / 16, 1.0 / 64, 1.0 / 256, 0.0};

/// sign e - t r.
lighting::ShDouble combined(const ErrorPair& pair, double sign, double t) {
    lighting::ShDouble out;
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i] = sign * static_cast<double>(pair.error[i]) - t * static_cast<double>(pair.reference[i]);
    return out;
}

lighting::Extrema exitExtrema(const lighting::ShDouble& coefficients) {
    return lighting::extremaOnSphere(lighting::sphereQuadratic(coefficients, lighting::kExitRadianceBands));
}

/// Maximum over normals, from above, without an eigenproblem.
double cheapMaximum(const lighting::ShDouble& k) {
    return kExitNorm[0] * k[0] + kExitNorm[1] * std::sqrt(k[1] * k[1] + k[2] * k[2] + k[3] * k[3]) +
           kExitNorm[2] * std::sqrt(k[4] * k[4] + k[5] * k[5] + k[6] * k[6] + k[7] * k[7] + k[8] * k[8]);
}

bool staysUnder(const ErrorPair& pair, double share, double floor, double rounding, double limit) {
    for (const double sign : {1.0, -1.0}) {
        const lighting::ShDouble k = combined(pair, sign, limit * share);
        if (cheapMaximum(k) + rounding <= limit * floor) continue;
        if (exitExtrema(k).maximum + rounding > limit * floor) return false;
    }
    return true;
}

double valueAt(const lighting::Sh& coefficients, const glm::dvec3& n) {
    lighting::ShDouble out;
    std::ranges::copy(coefficients, out.begin());
    return lighting::sphereQuadratic(out, lighting::kExitRadianceBands)(n);
}

/// Raises t until s e - t (share r + floor) is nowhere positive; infinity where it cannot.
double raised(const ErrorPair& pair, double sign, double share, double floor, double rounding, double t) {
    for (int step = 0; step < kMaximumSteps; ++step) {
        const lighting::Extrema extrema = exitExtrema(combined(pair, sign, t * share));
        if (extrema.maximum + rounding <= t * floor) return t;
        const double under = share * valueAt(pair.reference, extrema.maximumAt) + floor;
        if (under < kVanishing * floor) break;
        const double next = (sign * valueAt(pair.error, extrema.maximumAt) + rounding) / under;
        if (!(next > t * (1 + kRelativeSlack))) return t * (1 + 2 * kRelativeSlack);
        t = next;
    }
    return std::numeric_limits<double>::infinity();
}

}  // namespace

lighting::ShBands bandNorms(const lighting::Sh& c) {
    // In double: squares of floats neither vanish nor overflow in it.
    lighting::ShDouble k;
    std::ranges::copy(c, k.begin());
    return {std::abs(k[0]), std::sqrt(k[1] * k[1] + k[2] * k[2] + k[3] * k[3]),
            std::sqrt(k[4] * k[4] + k[5] * k[5] + k[6] * k[6] + k[7] * k[7] + k[8] * k[8])};
}

double bandSum(const lighting::ShBands& norms, const lighting::ShBands& factors) {
    return norms[0] * factors[0] + norms[1] * factors[1] + norms[2] * factors[2];
}

double localErrorBound(std::span<const ErrorPair> pairs, double floor, double rounding) {
    double bound = std::numeric_limits<double>::infinity();
    for (const double share : kShares) {
        double relative = 0;
        for (const ErrorPair& pair : pairs)
            for (const double sign : {1.0, -1.0})
                if (std::isfinite(relative)) relative = raised(pair, sign, share, floor, rounding, relative);
        bound = std::min(bound, relative);
    }
    return bound;
}

AxisCone axisCone(std::span<const glm::vec3> vectors, double rounding) {
    AxisCone cone{glm::vec3(0, 0, 1), std::numbers::sqrt3};
    glm::dvec3 sum(0);
    for (const glm::vec3& v : vectors) sum += glm::dvec3(v);
    if (!(glm::length(sum) > 0)) return cone;
    cone.axis = glm::vec3(glm::normalize(sum));
    double slope = 0;
    for (const glm::vec3& v : vectors) {
        const double along = glm::dot(glm::dvec3(cone.axis), glm::dvec3(v));
        const double across = glm::length(glm::dvec3(v) - along * glm::dvec3(cone.axis));
        if (!(along > 2 * rounding)) return cone;
        slope = std::max(slope, (across + 2 * rounding) / (along - 2 * rounding));
    }
    cone.deviation = std::numbers::sqrt3 * slope / std::sqrt(1 + slope * slope);
    return cone;
}

bool staysWithin(std::span<const ErrorPair> pairs, double floor, double rounding, double limit) {
    if (std::ranges::all_of(pairs,
                            [&](const ErrorPair& pair) { return bandSum(bandNorms(pair.error), kExitNorm) + rounding <= limit * floor; }))
        return true;
    return std::ranges::any_of(kShares, [&](double share) {
        return std::ranges::all_of(pairs, [&](const ErrorPair& pair) { return staysUnder(pair, share, floor, rounding, limit); });
    });
}

}  // namespace verify
