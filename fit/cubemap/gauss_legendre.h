// Gauss-Legendre quadrature on [0, 1]: integral of f = sum of weight[i] f(point[i]), exact for polynomials up to degree 2 n - 1.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace lightcook::fit {

template <int kCount>
struct GaussRule {
    std::array<double, kCount> point{}, weight{};  ///< weights add up to 1
};

/// Returns the rule of kCount points. Finds the roots of the Legendre polynomial by Newton's method from Chebyshev's estimate, which
/// converges to the last bits within eight steps.
template <int kCount>
GaussRule<kCount> gaussLegendre() {
    GaussRule<kCount> rule;
    for (int i = 0; i < kCount; ++i) {
        double x = std::cos(std::numbers::pi * (i + 0.75) / (kCount + 0.5)), derivative = 1;
        for (int iteration = 0; iteration < 8; ++iteration) {
            double previous = 1, current = x;
            for (int degree = 1; degree < kCount; ++degree) {
                const double next = ((2 * degree + 1) * x * current - degree * previous) / (degree + 1);
                previous = current;
                current = next;
            }
            derivative = kCount * (x * current - previous) / (x * x - 1);
            x -= current / derivative;
        }
        rule.point[static_cast<std::size_t>(i)] = 0.5 - 0.5 * x;
        rule.weight[static_cast<std::size_t>(i)] = 1 / ((1 - x * x) * derivative * derivative);
    }
    return rule;
}

}  // namespace lightcook::fit
