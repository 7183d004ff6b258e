#include "verify/error/visible_metric.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <limits>

#include "verify/error/perceptual_quantizer.h"

namespace lightcook::verify {
namespace {

constexpr double kLowest = 0x1p-8, kHighest = 10000;
double clamped(double nits) {
    return std::clamp(nits, kLowest, kHighest);
}

/// A point of the PQ curve and its slope.
struct CurvePoint {
    double nits, code, slope;
};
CurvePoint pointAt(double nits) {
    const double x = clamped(nits);
    const auto low = static_cast<float>(x);
    return {x, static_cast<double>(perceptualQuantizerOf(low)), static_cast<double>(perceptualSlopeOf(low)) / x};
}
double curve(double nits) {
    return static_cast<double>(perceptualQuantizerOf(static_cast<float>(nits)));
}
/// Errors of the curve in floats (perceptual_quantizer.h). Of the difference of two codes: covers 2e-7 each. Of a slope, as a part of it:
/// covers 1e-4, three times over.
constexpr double kCurveRounding = 6e-7, kSlopeRounding = 3e-4;
/// Error of the exponents of secantRatio(). Covers twice the 0.01 that steepness() states; its formula in doubles errs by less than 1e-8.
constexpr double kSteepnessMargin = 0.02;
/// Relative error of a bound in doubles, some hundred roundings of 1e-16.
constexpr double kBoundRounding = 1e-9;

constexpr double kUnbounded = std::numeric_limits<double>::infinity();

/// Returns the range of a sum of channels.
Interval sumOf(const glm::dvec3& weights, const Intervals& channels) {
    Interval sum;
    for (int c = 0; c < 3; ++c) sum = sum + weights[c] * channels[static_cast<std::size_t>(c)];
    return sum;
}

/// Returns the range of the difference of the codes of two luminances whose ratio lies in this range.
Interval codesOfRatio(const Interval& ratio) {
    const auto code = [](double of) { return of > 0 ? kSteepestSlope * std::log(of) : -kUnbounded; };
    return {std::min(0.0, code(ratio.low)) - kCurveRounding, std::max(0.0, code(ratio.high)) + kCurveRounding};
}

/// Returns the largest difference in T and P, for such differences of L' - M' and of S' - M'.
double colourOf(const Interval& red, const Interval& blue) {
    // A norm is convex: its maximum over a box is at a corner. The weights of T and of P sum to 0, so that M' needs no term of its own.
    double largest = 0;
    for (const double x : {red.low, red.high})
        for (const double y : {blue.low, blue.high}) {
            const double t = VisibleMetric::itp(1)[0] * x + VisibleMetric::itp(1)[2] * y,
                         p = VisibleMetric::itp(2)[0] * x + VisibleMetric::itp(2)[2] * y;
            largest = std::max(largest, t * t + p * p);
        }
    return std::sqrt(largest);
}

/// Returns the range of the difference of any two numbers of a range.
Interval differencesWithin(const Interval& range) {
    const double width = range.high - range.low;
    return {-width, width};
}

bool isFinite(const Interval& range) {
    return std::isfinite(range.low) && std::isfinite(range.high);
}

/// Returns the square of the largest difference of lights whose codes differ by at most these steps. A norm is convex: its maximum over a
/// box is at a corner, and opposite corners have the same.
double largestSquare(const std::array<double, 3>& step) {
    double largest = 0;
    for (int corner = 0; corner < 4; ++corner) {
        const glm::dvec3 at(step[0], (corner & 1) == 0 ? step[1] : -step[1], (corner & 2) == 0 ? step[2] : -step[2]);
        double squares = 0;
        for (int i = 0; i < 3; ++i) squares += glm::dot(VisibleMetric::itp(i), at) * glm::dot(VisibleMetric::itp(i), at);
        largest = std::max(largest, squares);
    }
    return largest;
}

/// Returns a range of light of which what is below zero counts as none.
Interval clampedLight(const Interval& light) {
    return {std::max(light.low, 0.0), std::max(light.high, 0.0)};
}

}  // namespace

VisibleMetric::VisibleMetric(const Viewing& viewing, double unit) : black_(viewing.display.black), isPositive_(true) {
    const glm::dmat3 lms = lighting::lmsFromBt2020() * viewing.bt2020FromWorking * (viewing.display.nitsPerUnit * unit);
    for (int row = 0; row < 3; ++row)
        for (int c = 0; c < 3; ++c) {
            lms_[static_cast<std::size_t>(row)][c] = lms[c][row];
            isPositive_ = isPositive_ && lms[c][row] >= 0;
        }
    // Light may lower L, M or S below black, where PQ falls to 0.
    const double darkest = isPositive_ ? curve(black_) - kCurveRounding : 0, most = 1 + kCurveRounding - darkest;
    Interval red{1, 1}, blue{1, 1};
    for (int c = 0; c < 3; ++c) {
        red = hullOf(red, Interval::around(lms_[0][c] / lms_[1][c], 0));
        blue = hullOf(blue, Interval::around(lms_[2][c] / lms_[1][c], 0));
    }
    const Interval any{-most, most};
    red = isPositive_ ? intersection(codesOfRatio(red), any) : any;
    blue = isPositive_ ? intersection(codesOfRatio(blue), any) : any;
    mostColour_ = colourOf(differencesWithin(red), differencesWithin(blue));
    mostVisible_ = roundedUp(std::hypot(lighting::kVisibleScale * most, mostColour_));
}

const glm::dvec3& VisibleMetric::itp(int row) {
    static const glm::dmat3 kRows = lighting::kVisibleScale * glm::transpose(lighting::itpFromLms());
    return kRows[row];
}

double VisibleMetric::largestStep() {
    static const double kLargest = std::sqrt(largestSquare({1, 1, 1}));
    return kLargest;
}

double VisibleMetric::roundedUp(double difference) {
    const double bound = difference * (1 + kBoundRounding) + kVisibleRounding;
    return bound < kUnbounded ? bound : kUnbounded;
}

double VisibleMetric::lowest(int row, const glm::dvec3& low) const {
    if (!isPositive_) return kLowest;
    double sum = black_;
    for (int c = 0; c < 3; ++c) sum += lms(row)[c] * std::max(low[c], 0.0);
    return sum;
}

bool VisibleMetric::cannotExceedCheaply(const glm::dvec3& low, const glm::dvec3& error, double limit) const {
    // |PQ(X) - PQ(Y)| <= kSteepestSlope |log(X / Y)|, and |log(1 - share)| <= 2 ln 2 share up to a share of 1/2. Opposite steps of the
    // codes make the largest difference.
    constexpr double kMostShare = 0.5, kLogarithm = 1.3863;
    double share = 0;
    for (int k = 0; k < 3; ++k) {
        double difference = 0;
        for (int c = 0; c < 3; ++c) difference += std::abs(lms(k)[c]) * error[c];
        // Also for NaN, of which nothing is known.
        if (!(difference <= kMostShare * std::max(lowest(k, low), kLowest))) return false;
        share = std::max(share, difference / std::max(lowest(k, low), kLowest));
    }
    return largestStep() * (kCurveRounding + kSteepestSlope * kLogarithm * share) + 2 * kVisibleRounding < limit;
}

double VisibleMetric::coarseBound(const glm::dvec3& low, const glm::dvec3& error) const {
    // Below kSteepestLuminance a difference of codes falls with a factor on both lights.
    std::array<double, 3> step{}, differences{}, uppers{}, lowers{};
    std::array<bool, 3> isOnCurve{};
    std::array<float, 8> nits{}, codes{};  // of the darker and of the brighter light for each of L, M and S, in lanes
    for (int k = 0; k < 3; ++k) {
        const auto at = static_cast<std::size_t>(k);
        double difference = 0;
        for (int c = 0; c < 3; ++c) difference += std::abs(lms(k)[c]) * error[c];
        // The curve is concave: codes differ most where the darker light is as dark as it may be, and the other one `difference` above
        // it. That is `upper`, unless the darker light may be black, which no factor makes darker.
        const double black = isPositive_ ? black_ : kLowest, upper = std::max(lowest(k, low), kLowest),
                     lower = std::max(upper - difference, black);
        const bool mayGoOut = upper - difference <= black;
        isOnCurve[at] = mayGoOut || upper + difference <= kSteepestLuminance;
        differences[at] = difference;
        uppers[at] = upper;
        lowers[at] = lower;
        nits[2 * at] = static_cast<float>(lower);
        nits[2 * at + 1] = static_cast<float>(std::max(upper, lower + difference));
    }
    for (std::size_t i = 0; i < nits.size(); ++i) codes[i] = perceptualQuantizerOf(nits[i]);
    for (std::size_t k = 0; k < 3; ++k) {
        step[k] = kCurveRounding + (isOnCurve[k] ? static_cast<double>(codes[2 * k + 1]) - static_cast<double>(codes[2 * k])
                                                 : kSteepestSlope * std::log(uppers[k] / lowers[k]));
        // Also for NaN, of which nothing is known.
        if (!(differences[k] < kHighest)) step[k] = 1;
    }
    return std::sqrt(std::min(largestSquare(step), squareWithinDisplay(0.5 * (step[0] + step[1])))) + kVisibleRounding;
}

double VisibleMetric::squareWithinDisplay(double lightness) const {
    return lighting::kVisibleScale * lightness * lighting::kVisibleScale * lightness + mostColour_ * mostColour_;
}

Interval VisibleMetric::slopes(const Interval& x, const Interval& y) {
    // Between ends this close the slope of one of them is as good as the secant, and has no cancellation.
    constexpr double kClose = 1.05;
    const auto secant = [](const CurvePoint& a, const CurvePoint& b, double rounding) {
        return (std::abs(b.code - a.code) + rounding) / std::abs(b.nits - a.nits);
    };
    const CurvePoint lowX = pointAt(x.low), lowY = pointAt(y.low), highX = pointAt(x.high), highY = pointAt(y.high);
    const auto isClose = [](const CurvePoint& a, const CurvePoint& b) {
        return std::max(a.nits, b.nits) <= kClose * std::min(a.nits, b.nits);
    };
    Interval out;
    out.high = isClose(lowX, lowY) ? (1 + kSlopeRounding) * std::max(lowX.slope, lowY.slope) : secant(lowX, lowY, kCurveRounding);
    // Codes differ less than light does if a luminance is clamped.
    if (std::min(x.low, y.low) >= kLowest && std::max(x.high, y.high) <= kHighest)
        out.low = isClose(highX, highY) ? (1 - kSlopeRounding) * std::min(highX.slope, highY.slope) : secant(highX, highY, -kCurveRounding);
    out.low = std::clamp(out.low, 0.0, out.high);
    return out;
}

double VisibleMetric::steepness(double nits) {
    // PQ(z) = b^m2 with b = (c1 + c2 y) / (1 + c3 y) and y = (z / 10000)^m1: the logarithm of z PQ'(z) is m1 log y + (m2 - 1) log b
    // - 2 log(1 + c3 y) and a constant.
    constexpr double kM1 = 2610.0 / 16384, kM2 = 2523.0 / 32, kC1 = 3424.0 / 4096, kC2 = 2413.0 / 128, kC3 = 2392.0 / 128;
    const double y = std::pow(clamped(nits) / kHighest, kM1);
    return 1 - kM1 * (1 + (kM2 - 1) * (kC2 * y / (kC1 + kC2 * y) - kC3 * y / (1 + kC3 * y)) - 2 * kC3 * y / (1 + kC3 * y));
}

Interval VisibleMetric::steepnessBetween(const Interval& nits) {
    return {steepness(nits.low) - kSteepnessMargin, steepness(nits.high) + kSteepnessMargin};
}

Interval VisibleMetric::codes(const Interval& x, const Interval& y, const Interval& difference, const Interval& slope) {
    Interval out = {difference.low < 0 ? slope.high * difference.low : slope.low * difference.low,
                    difference.high > 0 ? slope.high * difference.high : slope.low * difference.high};
    out = intersection(out, {curve(y.low) - curve(x.high) - kCurveRounding, curve(y.high) - curve(x.low) + kCurveRounding});
    if (difference.high > 0) out.high = std::min(out.high, curve(clamped(x.low) + difference.high) - curve(x.low) + kCurveRounding);
    if (difference.low < 0) out.low = std::max(out.low, curve(y.low) - curve(clamped(y.low) - difference.low) - kCurveRounding);
    return out;
}

Interval VisibleMetric::secantRatio(const Interval& ratio, const Interval& nits) {
    const auto [least, most] = steepnessBetween(nits);
    return {std::min(std::pow(ratio.high, -least), std::pow(ratio.high, -most)),
            std::max(std::pow(ratio.low, -least), std::pow(ratio.low, -most))};
}

double VisibleMetric::largest(const Intervals& codes) const {
    // A norm is convex: its maximum over a box is at a corner.
    double largest = 0;
    for (int corner = 0; corner < 8; ++corner) {
        glm::dvec3 at;
        for (int k = 0; k < 3; ++k) {
            const Interval& code = codes[static_cast<std::size_t>(k)];
            at[k] = (corner >> k & 1) == 0 ? code.low : code.high;
        }
        double squares = 0;
        for (int i = 0; i < 3; ++i) squares += glm::dot(itp(i), at) * glm::dot(itp(i), at);
        largest = squares <= largest ? largest : squares;
    }
    // NaN stays: a comparison with it fails.
    const double within = squareWithinDisplay((0.5 * (codes[0] + codes[1])).largest());
    return std::sqrt(within < largest ? within : largest);
}

Interval VisibleMetric::ratioOf(int row, int other, const Intervals& light) const {
    // A quotient of linear functions has its extrema at corners of a box in which its denominator is positive.
    Interval out{1, 1};
    for (int corner = 0; corner < 8; ++corner) {
        double over = black_, under = black_;
        for (int c = 0; c < 3; ++c) {
            const Interval& channel = light[static_cast<std::size_t>(c)];
            const double at = (corner >> c & 1) == 0 ? channel.low : channel.high;
            over += lms(row)[c] * at;
            under += lms(other)[c] * at;
        }
        if (!(under > 0)) return {0, kUnbounded};
        out = corner == 0 ? Interval{over / under, over / under} : hullOf(out, {over / under, over / under});
    }
    return out;
}

ShownRange VisibleMetric::shown(const Intervals& light) const {
    ShownRange out;
    for (int k = 0; k < 3; ++k) {
        Interval& nits = out.nits[static_cast<std::size_t>(k)];
        nits = sumOf(lms(k), light) + Interval{black_, black_};
        // Below 2^-8 cd/m^2 the curve falls to 0, apart from its polynomial.
        out.codes[static_cast<std::size_t>(k)] = {nits.low < kLowest ? 0 : curve(nits.low) - kCurveRounding,
                                                  curve(nits.high) + kCurveRounding};
    }
    const auto between = [&](int row) {
        return intersection(codesOfRatio(ratioOf(row, 1, light)), out.codes[static_cast<std::size_t>(row)] - out.codes[1]);
    };
    out.red = between(0);
    out.blue = between(2);
    return out;
}

double VisibleMetric::slopeBound(const ShownRange& reference, const ShownRange& found, const Intervals& error,
                                 const std::array<Interval, 3>& ratios) const {
    Interval nits = reference.nits[0];
    for (std::size_t k = 0; k < 3; ++k) nits = hullOf(nits, hullOf(reference.nits[k], found.nits[k]));
    if (!isWithinCurve(nits)) return kUnbounded;
    const double slope = slopes(reference.nits[0], found.nits[0]).high;
    double squares = 0;
    for (int row = 0; row < 3; ++row) {
        glm::dvec3 weights(0);
        double rest = 0;
        for (int k = 0; k < 3; ++k) {
            const Interval share = k == 0 ? Interval{1, 1} : secantRatio(ratios[static_cast<std::size_t>(k)], nits);
            weights += itp(row)[k] * 0.5 * (share.low + share.high) * lms(k);
            rest += std::abs(itp(row)[k]) * 0.5 * (share.high - share.low) * sumOf(lms(k), error).largest();
        }
        const double largest = slope * (sumOf(weights, error).largest() + rest);
        squares += largest * largest;
    }
    return std::sqrt(squares);
}

double VisibleMetric::bound(const Intervals& reference, const Intervals& found, const Intervals& error) const {
    Intervals x, y, off;
    for (std::size_t c = 0; c < 3; ++c) {
        x[c] = clampedLight(reference[c]);
        y[c] = clampedLight(found[c]);
        // Clamping multiplies the difference of two numbers by a factor in [0, 1].
        const bool isClamped = reference[c].low < 0 || found[c].low < 0;
        off[c] = intersection(isClamped ? hullOf(error[c], {0, 0}) : error[c], y[c] - x[c]);
        if (!isFinite(reference[c]) || !isFinite(found[c]) || !isFinite(error[c])) return kUnbounded;
    }
    const ShownRange a = shown(x), b = shown(y);
    Intervals steps;
    for (std::size_t k = 0; k < 3; ++k) {
        const Interval difference = intersection(sumOf(lms(static_cast<int>(k)), off), b.nits[k] - a.nits[k]);
        // The curve's polynomial does not hold below 2^-8 cd/m^2.
        steps[k] = std::min(a.nits[k].low, b.nits[k].low) < kLowest ? b.codes[k] - a.codes[k]
                                                                    : codes(a.nits[k], b.nits[k], difference, slopes(a.nits[k], b.nits[k]));
    }
    const double lightness = lighting::kVisibleScale * (0.5 * (steps[0] + steps[1])).largest(),
                 colour = colourOf(intersection(b.red - a.red, steps[0] - steps[1]), intersection(b.blue - a.blue, steps[2] - steps[1]));
    std::array<Interval, 3> ratios{};
    for (int k = 1; k < 3; ++k) ratios[static_cast<std::size_t>(k)] = hullOf(ratioOf(k, 0, x), ratioOf(k, 0, y));
    return roundedUp(std::min({std::hypot(lightness, colour), largest(steps), slopeBound(a, b, off, ratios)}));
}

double VisibleMetric::bound(const Intervals& reference, const Intervals& found) const {
    Intervals error;
    for (std::size_t c = 0; c < 3; ++c) error[c] = found[c] - reference[c];
    return bound(reference, found, error);
}

double VisibleMetric::greyBound(const Interval& reference, const Interval& found, const Interval& error) const {
    // L, M and S of grey light are equal, since their rows sum to 1, and so are their codes: the difference is that of I.
    const double nits = lms(0).x + lms(0).y + lms(0).z;
    const Interval black{black_, black_}, x = clampedLight(reference), y = clampedLight(found);
    const bool isClamped = reference.low < 0 || found.low < 0;
    const Interval off = intersection(isClamped ? hullOf(error, {0, 0}) : error, y - x);
    const Interval a = nits * x + black, b = nits * y + black;
    if (!isFinite(reference) || !isFinite(found) || !isFinite(error)) return kUnbounded;
    return roundedUp(lighting::kVisibleScale * codes(a, b, nits * off, slopes(a, b)).largest());
}

}  // namespace lightcook::verify
