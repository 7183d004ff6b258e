#include "verify/light_map/visible_metric.h"

#include <cmath>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

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

}  // namespace

VisibleMetric::VisibleMetric(const Viewing& viewing, double unit) : black_(viewing.display.black), isPositive_(true) {
    const glm::dmat3 lms = lighting::lmsFromBt2020() * viewing.bt2020FromWorking * (viewing.display.nitsPerUnit * unit);
    for (int row = 0; row < 3; ++row)
        for (int c = 0; c < 3; ++c) {
            lms_[static_cast<std::size_t>(row)][c] = lms[c][row];
            isPositive_ = isPositive_ && lms[c][row] >= 0;
        }
}

const glm::dvec3& VisibleMetric::itp(int row) {
    static const glm::dmat3 kRows = lighting::kVisibleScale * glm::transpose(lighting::itpFromLms());
    return kRows[row];
}

double VisibleMetric::lowest(int row, const glm::dvec3& low) const {
    if (!isPositive_) return kLowest;
    double sum = black_;
    for (int c = 0; c < 3; ++c) sum += lms(row)[c] * std::max(low[c], 0.0);
    return sum;
}

bool VisibleMetric::cannotExceedCheaply(const glm::dvec3& low, const glm::dvec3& error, double limit) const {
    // |PQ(X) - PQ(Y)| <= kSteepestSlope |log(X / Y)|, and |log(1 - share)| <= 2 ln 2 share up to a share of 1/2. Opposite steps of the
    // codes make the largest difference; `kLargest` is its length for steps of 1 (coarseBound).
    constexpr double kMostShare = 0.5, kLogarithm = 1.3863;
    static const double kLargest = [] {
        double largest = 0;
        for (int corner = 0; corner < 4; ++corner) {
            const glm::dvec3 at(1, (corner & 1) == 0 ? 1 : -1, (corner & 2) == 0 ? 1 : -1);
            double squares = 0;
            for (int i = 0; i < 3; ++i) squares += glm::dot(itp(i), at) * glm::dot(itp(i), at);
            largest = std::max(largest, squares);
        }
        return std::sqrt(largest);
    }();
    double share = 0;
    for (int k = 0; k < 3; ++k) {
        double difference = 0;
        for (int c = 0; c < 3; ++c) difference += std::abs(lms(k)[c]) * error[c];
        // Also for NaN, of which nothing is known.
        if (!(difference <= kMostShare * std::max(lowest(k, low), kLowest))) return false;
        share = std::max(share, difference / std::max(lowest(k, low), kLowest));
    }
    return kLargest * (kCurveRounding + kSteepestSlope * kLogarithm * share) + 2 * kVisibleRounding < limit;
}

double VisibleMetric::coarseBound(const glm::dvec3& low, const glm::dvec3& error) const {
    // Below kSteepestLuminance a difference of codes falls with a factor on both lights.
    std::array<double, 3> step{};
    for (int k = 0; k < 3; ++k) {
        double difference = 0;
        for (int c = 0; c < 3; ++c) difference += std::abs(lms(k)[c]) * error[c];
        // The curve is concave: codes differ most where the darker light is as dark as it may be, and the other one `difference` above
        // it. That is `upper`, unless the darker light may be black, which no factor makes darker.
        const double black = isPositive_ ? black_ : kLowest, upper = std::max(lowest(k, low), kLowest),
                     lower = std::max(upper - difference, black);
        const bool mayGoOut = upper - difference <= black;
        step[static_cast<std::size_t>(k)] = kCurveRounding + (mayGoOut || upper + difference <= kSteepestLuminance
                                                                  ? curve(std::max(upper, lower + difference)) - curve(lower)
                                                                  : kSteepestSlope * std::log(upper / lower));
        // Also for NaN, of which nothing is known.
        if (!(difference < kHighest)) step[static_cast<std::size_t>(k)] = 1;
    }
    // A norm is convex: its maximum over a box is at a corner, and opposite corners have the same.
    double largest = 0;
    for (int corner = 0; corner < 4; ++corner) {
        const glm::dvec3 at(step[0], (corner & 1) == 0 ? step[1] : -step[1], (corner & 2) == 0 ? step[2] : -step[2]);
        double squares = 0;
        for (int i = 0; i < 3; ++i) squares += glm::dot(itp(i), at) * glm::dot(itp(i), at);
        largest = std::max(largest, squares);
    }
    return std::sqrt(largest) + kVisibleRounding;
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
    // Where a luminance is clamped, codes differ less than light does.
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

Interval VisibleMetric::codes(const Interval& x, const Interval& y, const Interval& difference, const Interval& slope) {
    Interval out = {difference.low < 0 ? slope.high * difference.low : slope.low * difference.low,
                    difference.high > 0 ? slope.high * difference.high : slope.low * difference.high};
    out = intersection(out, {curve(y.low) - curve(x.high) - kCurveRounding, curve(y.high) - curve(x.low) + kCurveRounding});
    if (difference.high > 0) out.high = std::min(out.high, curve(clamped(x.low) + difference.high) - curve(x.low) + kCurveRounding);
    if (difference.low < 0) out.low = std::max(out.low, curve(y.low) - curve(clamped(y.low) - difference.low) - kCurveRounding);
    return out;
}

double VisibleMetric::largest(const Intervals& codes) {
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
    return std::sqrt(largest);
}

}  // namespace lightcook::verify
