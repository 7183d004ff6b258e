#include "verify/light_map/bound.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <optional>

#include "lighting/quadratic.h"

namespace lightcook::verify {

namespace {

/// Dinkelbach's iteration converges in four or five steps; a vanishing denominator ends it earlier.
constexpr int kMaximumSteps = 32;
/// In the first steps any violating direction may raise t, if it raises it by at least the factor kWorthwhile.
constexpr int kQuickSteps = 6;
constexpr double kWorthwhile = 1.001;
/// Gives up on a share whose denominator falls below this part of the floor: the reference is negative there, a smaller share is better.
constexpr double kVanishing = 1e-3;
constexpr double kRelativeSlack = 1e-12;
/// Relative error of sums and extrema in double, relative to the vectors' lengths: extremaOnSphere guarantees 1e-12.
constexpr double kArithmetic = 4e-12;
/// |r| >= share r for any share in [-1, 1]. Light that rings below zero by less than floor / share is bounded by that share of its bright
/// side, instead of by the floor alone (share 0).
constexpr std::array<double, 6> kShares = {1.0, 1.0 / 4, 1.0 / 16, 1.0 / 64, 1.0 / 256, 0.0};

/// Returns sign * error - t * reference.
lighting::ShDouble combined(const ErrorPair& pair, double sign, double t) {
    lighting::ShDouble out;
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i] = sign * static_cast<double>(pair.error[i]) - t * static_cast<double>(pair.reference[i]);
    return out;
}

/// Result of comparing the maximum of a quadratic on the sphere with a limit by a few iterations.
enum class Comparison { Below, Above, Undecided };

/// The matrix mu I - A of a quadratic c + b n + n A n, with its inverse.
class Shifted {
public:
    Shifted(const glm::dmat3& a, double mu) : m_{mu - a[0][0], -a[0][1], -a[0][2], mu - a[1][1], -a[1][2], mu - a[2][2]} {
        adjugate_ = {m_[3] * m_[5] - m_[4] * m_[4], m_[2] * m_[4] - m_[1] * m_[5], m_[1] * m_[4] - m_[2] * m_[3],
                     m_[0] * m_[5] - m_[2] * m_[2], m_[1] * m_[2] - m_[0] * m_[4], m_[0] * m_[3] - m_[1] * m_[1]};
        determinant_ = m_[0] * adjugate_[0] + m_[1] * adjugate_[1] + m_[2] * adjugate_[2];
    }
    /// Returns true if the matrix is positive definite, and well enough conditioned for products with its inverse to a relative 1e-13.
    bool isSound() const {
        constexpr double kSound = 1e-3;
        const double trace = m_[0] + m_[3] + m_[5];
        return m_[0] > 0 && adjugate_[5] > 0 && determinant_ > kSound * trace * trace * trace;
    }
    glm::dvec3 solve(const glm::dvec3& b) const {
        return glm::dvec3(adjugate_[0] * b.x + adjugate_[1] * b.y + adjugate_[2] * b.z,
                          adjugate_[1] * b.x + adjugate_[3] * b.y + adjugate_[4] * b.z,
                          adjugate_[2] * b.x + adjugate_[4] * b.y + adjugate_[5] * b.z) /
               determinant_;
    }

private:
    std::array<double, 6> m_, adjugate_{};  ///< xx xy xz yy yz zz
    double determinant_ = 0;
};

/// Compares the maximum of a quadratic over the sphere with a limit.
/// By duality, max_n (b n + n A n) = min_mu (mu + b (mu I - A)^-1 b / 4) over mu above the largest eigenvalue of A. Any such mu gives an
/// upper bound, and any direction a lower bound, so most comparisons end after a few steps, at a tenth of the cost of an eigenproblem. At
/// the optimal mu, y = (mu I - A)^-1 b / 2 has length 1 and is the maximum's direction; mu moves by Newton steps on 1 / |y| (as in
/// lighting/sh/quadratic.cpp).
/// above  if not null, receives a direction whose value exceeds the limit
Comparison compareMaximum(const lighting::SphereQuadratic& quadratic, double limit, glm::dvec3* above = nullptr) {
    constexpr int kSteps = 6;
    const double allowed = limit - quadratic.constant;
    const glm::dmat3& a = quadratic.symmetric;
    const glm::dvec3& b = quadratic.linear;
    double squares = 0;
    for (int i = 0; i < 3; ++i) squares += glm::dot(a[i], a[i]);
    const double slope = glm::length(b);
    double low = std::max({a[0][0], a[1][1], a[2][2]}), high = allowed;
    // A is traceless, so its eigenvalues are at most sqrt(2 / 3) of its norm.
    double mu = std::min(std::sqrt(squares / 1.5) + 0.5 * slope, allowed - 0.25 * slope);
    for (int step = 0; step < kSteps && high > low; ++step) {
        if (!(mu > low && mu < high)) mu = 0.5 * (low + high);
        const Shifted shifted(a, mu);
        if (!shifted.isSound()) {
            low = mu;
            continue;
        }
        const glm::dvec3 w = shifted.solve(b);
        const double along = glm::dot(b, w), squared = glm::dot(w, w);
        if (mu + 0.25 * along <= allowed) return Comparison::Below;
        if (!(squared > 0)) return Comparison::Undecided;
        const double length = std::sqrt(squared);
        if (along / length + mu - along / squared > allowed) {  // value of the quadratic at w / |w|
            if (above != nullptr) *above = w / length;
            return Comparison::Above;
        }
        (squared < 4 ? high : low) = mu;
        mu += (0.5 * length - 1) * squared / glm::dot(w, shifted.solve(w));
    }
    return Comparison::Undecided;
}

/// Returns true if the response to these coefficients is at most `limit` in every direction.
bool cannotExceed(const lighting::ShDouble& coefficients, const Response& response, double limit) {
    const lighting::SphereQuadratic quadratic = lighting::sphereQuadratic(coefficients, response.bands);
    const Comparison comparison = compareMaximum(quadratic, limit);
    return comparison == Comparison::Undecided ? lighting::extremaOnSphere(quadratic).maximum <= limit : comparison == Comparison::Below;
}

lighting::ShBands axialNorms(const Response& response) {
    return Response{response.bands, {}}.norms();
}

/// Returns an upper bound of the maximum over directions, from band lengths.
/// norms  axialNorms of the response
double cheapMaximum(const lighting::ShDouble& k, const lighting::ShBands& norms) {
    const lighting::ShBands lengths = lighting::bandLengths(k);
    return norms[0] * k[0] + norms[1] * lengths[1] + norms[2] * lengths[2];
}

/// The terms of one condition that do not depend on the direction: s e(n) + over <= t (share r(n) + floor).
struct Condition {
    double over = 0;   ///< slack and residual of the error
    double floor = 0;  ///< the floor, less the residual of the reference
};
Condition conditionOf(const ErrorPair& pair, const Response& response, double share, double floor, const lighting::ShBands& slack) {
    lighting::ShBands beside = response.residual;
    for (std::size_t l = 0; l < beside.size(); ++l) beside[l] += kArithmetic * response.bands[l];
    return {bandSum(slack, response.norms()) + bandSum(lighting::bandLengths(pair.error), beside),
            floor - share * bandSum(lighting::bandLengths(pair.reference), beside)};
}

/// Returns true if one pair under one response fulfils its condition with this share, for both signs.
bool cannotExceed(const ErrorPair& pair, const Response& response, double share, double floor, const lighting::ShBands& slack,
                  double limit) {
    const Condition condition = conditionOf(pair, response, share, floor, slack);
    const lighting::ShBands norms = axialNorms(response);
    const double allowed = limit * condition.floor - condition.over;
    for (const double sign : {1.0, -1.0}) {
        const lighting::ShDouble k = combined(pair, sign, limit * share);
        if (cheapMaximum(k, norms) <= allowed) continue;
        if (!cannotExceed(k, response, allowed)) return false;
    }
    return true;
}

double valueAt(const lighting::Sh& coefficients, const Response& response, const glm::dvec3& n) {
    lighting::ShDouble out;
    std::ranges::copy(coefficients, out.begin());
    return lighting::sphereQuadratic(out, response.bands)(n);
}

/// Raises t by Dinkelbach's iteration until s e + over <= t (share r + floor) in every direction. Returns infinity if no t satisfies this.
/// at  receives the direction that raised t last
double raised(const ErrorPair& pair, const Response& response, double sign, double share, double floor, const lighting::ShBands& slack,
              double t, std::optional<glm::dvec3>& at) {
    const Condition condition = conditionOf(pair, response, share, floor, slack);
    const lighting::ShBands norms = axialNorms(response);
    const auto denominatorAt = [&](const glm::dvec3& n) { return share * valueAt(pair.reference, response, n) + condition.floor; };
    const auto ratioAt = [&](const glm::dvec3& n, double denominator) {
        return (sign * valueAt(pair.error, response, n) + condition.over) / denominator;
    };
    for (int step = 0; step < kMaximumSteps; ++step) {
        const lighting::ShDouble k = combined(pair, sign, t * share);
        const double allowed = t * condition.floor - condition.over;
        if (cheapMaximum(k, norms) <= allowed) return t;
        const lighting::SphereQuadratic quadratic = lighting::sphereQuadratic(k, response.bands);
        glm::dvec3 place;
        const Comparison comparison = compareMaximum(quadratic, allowed, &place);
        if (comparison == Comparison::Below) return t;
        // Any direction above the limit raises t; only the exact maximum can end the iteration.
        if (comparison == Comparison::Above && step < kQuickSteps) {
            const double denominator = denominatorAt(place);
            const double next = denominator >= kVanishing * floor ? ratioAt(place, denominator) : 0;
            if (next > t * kWorthwhile) {
                t = next;
                at = place;
                continue;
            }
        }
        const lighting::Extrema extrema = lighting::extremaOnSphere(quadratic);
        if (extrema.maximum <= allowed) return t;
        const double denominator = denominatorAt(extrema.maximumAt);
        if (!(denominator >= kVanishing * floor)) break;
        const double next = ratioAt(extrema.maximumAt, denominator);
        if (!(next > t * (1 + kRelativeSlack))) return t * (1 + 2 * kRelativeSlack);
        t = next;
        at = extrema.maximumAt;
    }
    return std::numeric_limits<double>::infinity();
}

/// Returns true if all coefficients are finite. Nothing can be proven about NaN.
bool areFinite(std::span<const ErrorPair> pairs) {
    const auto isFinite = [](double value) { return std::isfinite(value); };
    return std::ranges::all_of(pairs, [&](const ErrorPair& pair) {
        return std::ranges::all_of(pair.error, isFinite) && std::ranges::all_of(pair.reference, isFinite);
    });
}

}  // namespace

double bandSum(const lighting::ShBands& lengths, const lighting::ShBands& factors) {
    return lengths[0] * factors[0] + lengths[1] * factors[1] + lengths[2] * factors[2];
}

lighting::ShBands Response::norms() const {
    lighting::ShBands out = residual;
    constexpr lighting::ShBands kLargest = {lighting::kShConstant, lighting::kShLinear, 2 * lighting::kShZonal};
    for (std::size_t l = 0; l < out.size(); ++l) out[l] += bands[l] * kLargest[l];
    return out;
}

double localErrorBound(std::span<const ErrorPair> pairs, std::span<const Response> responses, double floor, const lighting::ShBands& slack,
                       double atMost, BoundPlace* place) {
    if (!areFinite(pairs)) return std::numeric_limits<double>::infinity();
    double bound = atMost;
    for (const double share : kShares) {
        double relative = 0;
        bool isUntested = false;
        BoundPlace reached;
        const auto raiseByAll = [&] {
            for (const Response& response : responses)
                for (std::size_t i = 0; i < pairs.size(); ++i)
                    for (const double sign : {1.0, -1.0}) {
                        if (!(relative < bound)) continue;
                        std::optional<glm::dvec3> at;
                        relative = raised(pairs[i], response, sign, share, floor, slack, relative, at);
                        isUntested = isUntested || relative == 0;
                        if (at && place != nullptr)
                            reached = {i, *at, valueAt(pairs[i].error, response, *at), valueAt(pairs[i].reference, response, *at),
                                       response.bands};
                    }
        };
        raiseByAll();
        // Both signs of a condition that holds at t > 0 hold at every larger t, since share r + floor is not negative then. At t = 0 an
        // error of 0 fulfils its condition whatever the reference is.
        if (isUntested && relative > 0) raiseByAll();
        if (!(relative < bound)) continue;
        bound = relative;
        if (place != nullptr) *place = reached;
    }
    return bound;
}

double shadedAbout(const lighting::Sh& light, const lighting::ShBands& bands, const glm::dvec3& n) {
    return valueAt(light, Response{bands, {}}, n);
}

bool cannotExceed(std::span<const ErrorPair> pairs, std::span<const Response> responses, double floor, const lighting::ShBands& slack,
                  double limit) {
    if (!areFinite(pairs)) return false;
    return std::ranges::all_of(responses,
                               [&](const Response& response) {
                                   const lighting::ShBands norms = response.norms();
                                   const double allowed = limit * floor - bandSum(slack, norms);
                                   return std::ranges::all_of(pairs, [&](const ErrorPair& pair) {
                                       return bandSum(lighting::bandLengths(pair.error), norms) <= allowed;
                                   });
                               }) ||
           std::ranges::any_of(kShares, [&](double share) {
               return std::ranges::all_of(responses, [&](const Response& response) {
                   return std::ranges::all_of(
                       pairs, [&](const ErrorPair& pair) { return cannotExceed(pair, response, share, floor, slack, limit); });
               });
           });
}

}  // namespace lightcook::verify
