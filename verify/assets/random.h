// Seeded pseudorandom numbers for choosing samples. They are the same on every machine, which the standard library's distributions do not
// guarantee. Private to verify/.
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/vec3.hpp>
#include <numbers>

namespace lightcook::verify {

class Random {
public:
    explicit Random(std::uint64_t seed) : state_(seed) {}
    /// Returns a number uniform in [0, 1).
    double next() { return static_cast<double>(bits() >> 11) * 0x1p-53; }
    /// Returns a number uniform in 0 .. count - 1.
    int below(int count) { return static_cast<int>(next() * count); }
    /// Returns a unit vector uniform on the sphere.
    glm::dvec3 direction() {
        const double z = 2 * next() - 1, phi = 2 * std::numbers::pi * next(), radius = std::sqrt(1 - z * z);
        return {radius * std::cos(phi), radius * std::sin(phi), z};
    }

private:
    /// SplitMix64 (Steele, Lea and Flood 2014): a counter through a strong mixing function.
    std::uint64_t bits() {
        std::uint64_t z = state_ += 0x9e3779b97f4a7c15u;
        z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
        z = (z ^ z >> 27) * 0x94d049bb133111ebu;
        return z ^ z >> 31;
    }
    std::uint64_t state_;
};

}  // namespace lightcook::verify
