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
/// What sums and extrema in double may be off, as a part of the lengths that go into them: extremaOnSphere promises 1e-12.
constexpr double kArithmetic = 4e-12;
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

lighting::Extrema extremaOf(const lighting::ShDouble& coefficients, const Response& response) {
    return lighting::extremaOnSphere(lighting::sphereQuadratic(coefficients, response.bands));
}

lighting::ShBands normsOf(const lighting::ShDouble& k) {
    return {std::abs(k[0]), std::sqrt(k[1] * k[1] + k[2] * k[2] + k[3] * k[3]),
            std::sqrt(k[4] * k[4] + k[5] * k[5] + k[6] * k[6] + k[7] * k[7] + k[8] * k[8])};
}

lighting::ShBands axialNorms(const Response& response) {
    return Response{response.bands, {}}.norms();
}

/// Maximum over directions, from above, without an eigenproblem. norms: axialNorms of the response
double cheapMaximum(const lighting::ShDouble& k, const lighting::ShBands& norms) {
    const lighting::ShBands lengths = normsOf(k);
    return norms[0] * k[0] + norms[1] * lengths[1] + norms[2] * lengths[2];
}

/// One condition of the bound: error and reference of a pair under a response, with all that is beside the quadratic.
struct Condition {
    double over = 0;   ///< added to the error
    double floor = 0;  ///< what is left of it for this share of the reference
};
Condition conditionOf(const ErrorPair& pair, const Response& response, double share, double floor, const lighting::ShBands& slack) {
    lighting::ShBands beside = response.residual;
    for (std::size_t l = 0; l < beside.size(); ++l) beside[l] += kArithmetic * response.bands[l];
    return {bandSum(slack, response.norms()) + bandSum(bandNorms(pair.error), beside),
            floor - share * bandSum(bandNorms(pair.reference), beside)};
}

bool staysUnder(const ErrorPair& pair, const Response& response, double share, double floor, const lighting::ShBands& slack, double limit) {
    const Condition condition = conditionOf(pair, response, share, floor, slack);
    const lighting::ShBands norms = axialNorms(response);
    const double allowed = limit * condition.floor - condition.over;
    for (const double sign : {1.0, -1.0}) {
        const lighting::ShDouble k = combined(pair, sign, limit * share);
        if (cheapMaximum(k, norms) <= allowed) continue;
        if (!(extremaOf(k, response).maximum <= allowed)) return false;
    }
    return true;
}

double valueAt(const lighting::Sh& coefficients, const Response& response, const glm::dvec3& n) {
    lighting::ShDouble out;
    std::ranges::copy(coefficients, out.begin());
    return lighting::sphereQuadratic(out, response.bands)(n);
}

/// The same for all pairs at once, by their middle and how far they are from it: one extremum where pairs are alike.
class Middle {
public:
    explicit Middle(std::span<const ErrorPair> pairs) {
        for (std::size_t i = 0; i < error_.size(); ++i) {
            for (const ErrorPair& pair : pairs) {
                error_[i] += static_cast<double>(pair.error[i]);
                reference_[i] += static_cast<double>(pair.reference[i]);
            }
            error_[i] /= static_cast<double>(pairs.size());
            reference_[i] /= static_cast<double>(pairs.size());
        }
        for (const ErrorPair& pair : pairs) {
            lighting::ShDouble error, reference;
            for (std::size_t i = 0; i < error.size(); ++i) {
                error[i] = static_cast<double>(pair.error[i]) - error_[i];
                reference[i] = static_cast<double>(pair.reference[i]) - reference_[i];
            }
            raise(errorSpread_, normsOf(error));
            raise(referenceSpread_, normsOf(reference));
            raise(errorNorms_, bandNorms(pair.error));
            raise(referenceNorms_, bandNorms(pair.reference));
        }
    }
    bool staysUnder(const Response& response, double share, double floor, const lighting::ShBands& slack, double limit) const {
        lighting::ShBands beside = response.residual;
        for (std::size_t l = 0; l < beside.size(); ++l) beside[l] += kArithmetic * response.bands[l];
        const lighting::ShBands norms = axialNorms(response);
        const double t = limit * share;
        const double allowed = limit * floor - bandSum(slack, response.norms()) - bandSum(errorNorms_, beside) -
                               t * bandSum(referenceNorms_, beside) - bandSum(errorSpread_, norms) - t * bandSum(referenceSpread_, norms);
        for (const double sign : {1.0, -1.0}) {
            lighting::ShDouble k;
            for (std::size_t i = 0; i < k.size(); ++i) k[i] = sign * error_[i] - t * reference_[i];
            if (cheapMaximum(k, norms) <= allowed) continue;
            if (!(allowed > norms[0] * k[0]) || !(extremaOf(k, response).maximum <= allowed)) return false;
        }
        return true;
    }

private:
    static void raise(lighting::ShBands& largest, const lighting::ShBands& each) {
        for (std::size_t l = 0; l < each.size(); ++l) largest[l] = largest[l] >= each[l] ? largest[l] : each[l];
    }
    lighting::ShDouble error_{}, reference_{};
    lighting::ShBands errorSpread_{}, referenceSpread_{}, errorNorms_{}, referenceNorms_{};
};

bool isUnderAsOne(std::span<const ErrorPair> pairs, std::span<const Response> responses, double floor, const lighting::ShBands& slack,
                  double limit) {
    const Middle middle(pairs);
    // Light that rings is rarely settled at a glance with less than a quarter of itself.
    return std::ranges::any_of(std::span(kShares).first(2), [&](double share) {
        return std::ranges::all_of(responses,
                                   [&](const Response& response) { return middle.staysUnder(response, share, floor, slack, limit); });
    });
}

/// Raises t until s e - t (share r + floor) is nowhere positive; infinity where it cannot.
double raised(const ErrorPair& pair, const Response& response, double sign, double share, double floor, const lighting::ShBands& slack,
              double t) {
    const Condition condition = conditionOf(pair, response, share, floor, slack);
    for (int step = 0; step < kMaximumSteps; ++step) {
        const lighting::ShDouble k = combined(pair, sign, t * share);
        const double allowed = t * condition.floor - condition.over;
        if (cheapMaximum(k, axialNorms(response)) <= allowed) return t;
        const lighting::Extrema extrema = extremaOf(k, response);
        if (extrema.maximum <= allowed) return t;
        const double under = share * valueAt(pair.reference, response, extrema.maximumAt) + condition.floor;
        if (!(under >= kVanishing * floor)) break;
        const double next = (sign * valueAt(pair.error, response, extrema.maximumAt) + condition.over) / under;
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

lighting::ShBands Response::norms() const {
    lighting::ShBands out = residual;
    constexpr lighting::ShBands kLargest = {lighting::kShConstant, lighting::kShLinear, 2 * lighting::kShZonal};
    for (std::size_t l = 0; l < out.size(); ++l) out[l] += bands[l] * kLargest[l];
    return out;
}

double localErrorBound(std::span<const ErrorPair> pairs, std::span<const Response> responses, double floor,
                       const lighting::ShBands& slack) {
    double bound = std::numeric_limits<double>::infinity();
    for (const double share : kShares) {
        double relative = 0;
        for (const Response& response : responses)
            for (const ErrorPair& pair : pairs)
                for (const double sign : {1.0, -1.0})
                    if (relative < bound) relative = raised(pair, response, sign, share, floor, slack, relative);
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

bool staysWithin(std::span<const ErrorPair> pairs, std::span<const Response> responses, double floor, const lighting::ShBands& slack,
                 double limit) {
    return std::ranges::all_of(responses,
                               [&](const Response& response) {
                                   const lighting::ShBands norms = response.norms();
                                   const double allowed = limit * floor - bandSum(slack, norms);
                                   return std::ranges::all_of(
                                       pairs, [&](const ErrorPair& pair) { return bandSum(bandNorms(pair.error), norms) <= allowed; });
                               }) ||
           (pairs.size() > 1 && isUnderAsOne(pairs, responses, floor, slack, limit)) || std::ranges::any_of(kShares, [&](double share) {
               return std::ranges::all_of(responses, [&](const Response& response) {
                   return std::ranges::all_of(
                       pairs, [&](const ErrorPair& pair) { return staysUnder(pair, response, share, floor, slack, limit); });
               });
           });
}

}  // namespace verify
