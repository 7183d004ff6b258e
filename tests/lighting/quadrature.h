// Quadrature for the tests: Gauss-Legendre rules and integrals over the sphere that share no code with the code under test.
#pragma once

#include <cmath>
#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>
#include <numbers>
#include <random>
#include <vector>

namespace lightcook::lighting::test {

inline constexpr double kPi = std::numbers::pi;

struct Rule {
    std::vector<double> nodes, weights;
};

/// Gauss-Legendre rule of n points on [from, to]: exact for polynomials of degree 2n - 1.
inline Rule gaussLegendre(int n, double from, double to) {
    Rule rule;
    for (int i = 0; i < n; ++i) {
        double x = std::cos(std::numbers::pi * (i + 0.75) / (n + 0.5)), derivative = 1;
        for (int step = 0; step < 50; ++step) {
            double p = 1, previous = 0;
            for (int k = 1; k <= n; ++k) {
                const double next = ((2 * k - 1) * x * p - (k - 1) * previous) / k;
                previous = p;
                p = next;
            }
            derivative = n * (x * p - previous) / (x * x - 1);
            const double change = p / derivative;
            x -= change;
            if (std::abs(change) < 1e-16) break;
        }
        rule.nodes.push_back(from + (to - from) * (1 - x) / 2);
        rule.weights.push_back((to - from) / ((1 - x * x) * derivative * derivative));
    }
    return rule;
}

/// Integrates over the sphere by visit(direction, weight): n heights by 2n azimuths, exact for polynomials of degree 2n - 1.
template <class Visit>
void overSphere(int n, Visit visit) {
    const Rule heights = gaussLegendre(n, -1, 1);
    for (int i = 0; i < n; ++i) {
        const double z = heights.nodes[static_cast<std::size_t>(i)], radius = std::sqrt(1 - z * z);
        for (int j = 0; j < 2 * n; ++j) {
            const double phi = std::numbers::pi * (j + 0.3) / n;  // 0.3: no symmetry that could hide a mistake
            visit(glm::dvec3(radius * std::cos(phi), radius * std::sin(phi), z),
                  heights.weights[static_cast<std::size_t>(i)] * std::numbers::pi / n);
        }
    }
}

inline glm::dvec3 randomDirection(std::mt19937_64& random) {
    std::normal_distribution<double> normal;
    for (;;) {
        const double x = normal(random), y = normal(random), z = normal(random);
        const double length = std::sqrt(x * x + y * y + z * z);
        if (length > 1e-3) return {x / length, y / length, z / length};
    }
}

/// Returns a proper rotation from a random unit quaternion.
inline glm::dmat3 randomRotation(std::mt19937_64& random) {
    std::normal_distribution<double> normal;
    double q[4], squared = 0;
    for (double& value : q) {
        value = normal(random);
        squared += value * value;
    }
    for (double& value : q) value /= std::sqrt(squared);
    const double w = q[0], x = q[1], y = q[2], z = q[3];
    return {glm::dvec3(1 - 2 * (y * y + z * z), 2 * (x * y + w * z), 2 * (x * z - w * y)),
            glm::dvec3(2 * (x * y - w * z), 1 - 2 * (x * x + z * z), 2 * (y * z + w * x)),
            glm::dvec3(2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y))};
}

}  // namespace lightcook::lighting::test
