// Intervals of numbers, for bounds. Private to verify/.
#pragma once

#include <algorithm>

namespace lightcook::verify {

struct Interval {
    double low = 0, high = 0;

    static Interval around(double middle, double radius) { return {middle - radius, middle + radius}; }
    double largest() const { return std::max(-low, high); }  ///< size of the largest number
    friend Interval operator+(const Interval& a, const Interval& b) { return {a.low + b.low, a.high + b.high}; }
    friend Interval operator*(double factor, const Interval& a) {
        return factor < 0 ? Interval{factor * a.high, factor * a.low} : Interval{factor * a.low, factor * a.high};
    }
    friend Interval operator*(const Interval& a, const Interval& b) {
        const double p = a.low * b.low, q = a.low * b.high, r = a.high * b.low, s = a.high * b.high;
        return {std::min({p, q, r, s}), std::max({p, q, r, s})};
    }
    /// Returns the differences of a number in `a` and one in `b`.
    friend Interval operator-(const Interval& a, const Interval& b) { return {a.low - b.high, a.high - b.low}; }
};
/// Returns what two intervals that enclose the same number have in common. Rounding may leave nothing: then a point.
inline Interval intersection(const Interval& a, const Interval& b) {
    const double low = std::max(a.low, b.low);
    return {low, std::max(low, std::min(a.high, b.high))};
}
/// Returns the smallest interval that contains both.
inline Interval hullOf(const Interval& a, const Interval& b) {
    return {std::min(a.low, b.low), std::max(a.high, b.high)};
}

}  // namespace lightcook::verify
