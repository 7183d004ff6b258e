// Upper bounds of the visible error (Delta E ITP) of ranges of light. Private to verify/.
//
// A display shows light x as L, M, S: X_k = black + sum_c M_kc max(x_c, 0), and the PQ curve turns each into a code. The curve rises, and
// its slope falls, between 2^-8 and 10000 cd/m^2, beyond which luminances are clamped. Hence, for X in [a, b] and a difference D,
//   PQ(Y) - PQ(X) = s D,  with s between the secants over the upper and over the lower ends of X and Y,
//   |PQ(X + D) - PQ(X)| <= PQ(m + |D|) - PQ(m),  m <= min(X, X + D).
// I, T and P are linear in the codes, so that at mean slopes they are linear in the error: grey errors stay grey.
//
// No two lights differ by more than a number of the display's (mostVisible). The codes lie in [PQ(black), 1], so I = (L' + M') / 2 differs
// by at most 1 - PQ(black). T and P are sums of L' - M' and S' - M' (their weights of the codes sum to 0), and
//   |L' - M'| <= kSteepestSlope |log(L / M)|,
// where L / M lies between 1, that of black, and the ratios of the channels: a mean of ratios lies between them. The same holds for S / M.
// So (T, P) lies in a parallelogram whose diagonals bound its differences. 766 Delta E ITP on the usual display.
#pragma once

#include <algorithm>
#include <array>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

#include "verify/error/interval.h"
#include "verify/visible.h"

namespace lightcook::verify {

using Intervals = std::array<Interval, 3>;

/// Added to every bound [Delta E ITP]. Covers the curve in floats that sampled figures come from: each code is within 2e-7 of PQ, and steps
/// of 1 in all three codes are less than 6600 Delta E ITP.
inline constexpr double kVisibleRounding = 0.01;

/// X PQ'(X), the slope of the curve over the natural logarithm of the luminance X, rises up to kSteepestLuminance [cd/m^2] and is nowhere
/// more than kSteepestSlope. Found numerically from the formula of SMPTE ST 2084: the maximum is 0.1091161, at 1341.57 cd/m^2.
inline constexpr double kSteepestLuminance = 1341, kSteepestSlope = 0.10912;

/// A range of light as a display shows it: luminances L, M and S, and differences of their codes.
struct ShownRange {
    Intervals nits;  ///< [cd/m^2]
    Intervals codes;
    Interval red, blue;  ///< L' - M' and S' - M'
};

/// The display's metric, with enclosures.
class VisibleMetric {
public:
    /// unit  light of the scene for each unit of the light that is bounded
    VisibleMetric(const Viewing& viewing, double unit);

    /// Returns the luminances L, M, S of one unit of each channel [cd/m^2].
    const glm::dvec3& lms(int row) const { return lms_[static_cast<std::size_t>(row)]; }
    /// Returns the factors of the codes L', M', S' in I, T or P, scaled to Delta E ITP.
    static const glm::dvec3& itp(int row);
    /// Returns the largest difference of lights whose codes differ by at most 1 each.
    static double largestStep();
    double black() const { return black_; }
    /// Returns true if no channel lowers L, M or S.
    bool isPositive() const { return isPositive_; }
    /// Returns the lowest L, M or S of light that is nowhere below `low` by channel.
    double lowest(int row, const glm::dvec3& low) const;

    /// Returns an upper bound of the difference of any two lights whose numbers are finite: 555 to 929 Delta E ITP for Rec.709 and
    /// BT.2020, by the black of the display (0.005 to 100 cd/m^2).
    double mostVisible() const { return mostVisible_; }
    /// Returns the same of the difference in T and P alone.
    double mostColour() const { return mostColour_; }
    /// Returns an upper bound of the difference of any light in a box of channels and any in another one; infinite unless
    /// all numbers are finite.
    /// error  range of found - reference, by channel
    double bound(const Intervals& reference, const Intervals& found, const Intervals& error) const;
    double bound(const Intervals& reference, const Intervals& found) const;
    /// Returns the same of grey lights, whose channels are equal.
    double greyBound(const Interval& reference, const Interval& found, const Interval& error) const;

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
    /// Returns an interval of it over luminances, rounding included.
    static Interval steepnessBetween(const Interval& nits);
    /// Returns an interval of PQ(y) - PQ(x), for y - x in `difference` and the secant in `slope`.
    static Interval codes(const Interval& x, const Interval& y, const Interval& difference, const Interval& slope);
    /// Returns an interval of the ratio of the curve's secant at one luminance to that at another one. Between z and a multiple rho z the
    /// slope changes by rho^-alpha, with alpha = 1 - d log(z PQ'(z)) / d log z, which rises with z; so does a secant if both of its ends
    /// have ratios in one interval. ratio  of the one luminance to the other nits   contains all luminances
    static Interval secantRatio(const Interval& ratio, const Interval& nits);
    /// Returns a difference with the rounding of sums and of the curve added; infinite for NaN.
    static double roundedUp(double difference);
    /// Returns an upper bound of the difference of two lights whose codes differ by any of a box.
    double largest(const Intervals& codes) const;

private:
    /// Returns the range of luminance that a box of channels is shown with.
    ShownRange shown(const Intervals& light) const;
    /// Returns an interval of the ratio of two of L, M and S of any light in a box, or of black.
    Interval ratioOf(int row, int other, const Intervals& light) const;
    /// Returns the bound by the mean slopes of the curve. Infinite where the curve is clamped.
    /// ratios  of M and S to L, of both lights
    double slopeBound(const ShownRange& reference, const ShownRange& found, const Intervals& error,
                      const std::array<Interval, 3>& ratios) const;
    /// Returns the square of the largest difference of two lights whose codes I differ by this much.
    double squareWithinDisplay(double lightness) const;

    std::array<glm::dvec3, 3> lms_;
    double black_;
    double mostColour_ = 0;  ///< largest difference in T and P
    double mostVisible_ = 0;
    bool isPositive_;  ///< no channel lowers L, M or S
};

}  // namespace lightcook::verify
