// Upper bounds of the visible error (Delta E ITP) of ranges of light. Private to verify/.
//
// A display shows light x as L, M, S: X_k = black + sum_c M_kc max(x_c, 0), and the PQ curve turns each into a code. The curve rises, and
// its slope falls, between 2^-8 and 10000 cd/m^2, beyond which luminances are clamped. Hence, for X in [a, b] and a difference D,
//   PQ(Y) - PQ(X) = s D,  with s between the secants over the upper and over the lower ends of X and Y,
//   |PQ(X + D) - PQ(X)| <= PQ(m + |D|) - PQ(m),  m <= min(X, X + D).
// I, T and P are linear in the codes, so that at mean slopes they are linear in the error: grey errors stay grey.
#pragma once

#include <algorithm>
#include <array>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "verify/visible.h"

namespace lightcook::verify {

struct Interval {
    double low = 0, high = 0;
    double largest() const { return std::max(-low, high); }
    friend Interval operator+(const Interval& a, const Interval& b) { return {a.low + b.low, a.high + b.high}; }
    friend Interval operator*(double factor, const Interval& a) {
        return factor < 0 ? Interval{factor * a.high, factor * a.low} : Interval{factor * a.low, factor * a.high};
    }
};
/// Returns what two intervals that enclose the same number have in common. Rounding may leave nothing: then a point.
inline Interval intersection(const Interval& a, const Interval& b) {
    const double low = std::max(a.low, b.low);
    return {low, std::max(low, std::min(a.high, b.high))};
}

using Intervals = std::array<Interval, 3>;

/// Added to every bound [Delta E ITP]. Covers the curve in floats that sampled figures come from: each code is within 2e-7 of PQ, and steps
/// of 1 in all three codes are less than 6600 Delta E ITP.
inline constexpr double kVisibleRounding = 0.01;

/// X PQ'(X), the slope of the curve over the natural logarithm of the luminance X, rises up to kSteepestLuminance [cd/m^2] and is nowhere
/// more than kSteepestSlope. Found numerically from the formula of SMPTE ST 2084: the maximum is 0.1091161, at 1341.57 cd/m^2.
inline constexpr double kSteepestLuminance = 1341, kSteepestSlope = 0.10912;

/// The display's metric, with enclosures.
class VisibleMetric {
public:
    /// unit  light of the scene for each unit of the light that is bounded
    VisibleMetric(const Viewing& viewing, double unit);

    /// Returns the luminances L, M, S of one unit of each channel [cd/m^2].
    const glm::dvec3& lms(int row) const { return lms_[static_cast<std::size_t>(row)]; }
    /// Returns the factors of the codes L', M', S' in I, T or P, scaled to Delta E ITP.
    static const glm::dvec3& itp(int row);
    double black() const { return black_; }
    /// Returns the lowest L, M or S of light that is nowhere below `low` by channel.
    double lowest(int row, const glm::dvec3& low) const;

    /// Returns an upper bound of the difference of any light above `low` (by channel) whose channels are off by at most `error`, and of
    /// both times any number in [0, 1].
    double coarseBound(const glm::dvec3& low, const glm::dvec3& error) const;

    /// Conservative test: true only if the coarse bound is proven to be below `limit`. Evaluates no point of the curve.
    bool cannotExceedCheaply(const glm::dvec3& low, const glm::dvec3& error, double limit) const;

    /// Returns true if the curve clamps none of these luminances.
    static bool isWithinCurve(const Interval& nits) { return nits.low >= 0x1p-8 && nits.high <= 10000; }
    /// Returns an interval of the secant of the curve between numbers in x and in y.
    static Interval slopes(const Interval& x, const Interval& y);
    /// Returns 1 - d log(z PQ'(z)) / d log z, within 0.01. It rises with the luminance z.
    static double steepness(double nits);
    /// Returns an interval of PQ(y) - PQ(x), for y - x in `difference` and the secant in `slope`.
    static Interval codes(const Interval& x, const Interval& y, const Interval& difference, const Interval& slope);
    /// Returns the largest difference of codes in a box.
    static double largest(const Intervals& codes);

private:
    std::array<glm::dvec3, 3> lms_;
    double black_;
    bool isPositive_;  ///< no channel lowers L, M or S
};

}  // namespace lightcook::verify
