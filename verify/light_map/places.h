// Places of quads, chosen by seed and quad alone. Private to verify/.
#pragma once

#include <cstdint>
#include <glm/vec2.hpp>

#include "verify/light_map/covered_quad.h"

namespace lightcook::verify::lightmap {

/// Returns a pseudorandom number in [0, 1) that depends on seed and place only.
inline float hashedFraction(std::uint64_t seed, std::uint64_t place) {
    std::uint64_t z = seed * 0x9e3779b97f4a7c15u + place * 0xbf58476d1ce4e5b9u + 0x94d049bb133111ebu;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return static_cast<float>((z ^ (z >> 31)) >> 40) * 0x1p-24f;
}

/// A random place of a quad: the same for the same seed, quad and sample, in whatever order quads are visited.
class RandomPlace {
public:
    RandomPlace(std::uint64_t seed, const CoveredQuad& quad, int placesPerTexel, int sample) : seed_(seed) {
        // Quads begin at -1.
        const auto quadIndex =
            static_cast<std::uint64_t>(quad.y + 1) * static_cast<std::uint64_t>(quad.mapWidth + 1) + static_cast<std::uint64_t>(quad.x + 1);
        index_ = quadIndex * static_cast<std::uint64_t>(placesPerTexel) + static_cast<std::uint64_t>(sample);
    }
    /// Returns the place, in fractions of the quad.
    glm::vec2 inQuad() const { return {hashedFraction(seed_, 2 * index_), hashedFraction(seed_, 2 * index_ + 1)}; }
    /// Returns a further number in [0, 1), independent of the place.
    float third() const { return hashedFraction(~seed_, index_); }

private:
    std::uint64_t seed_, index_;
};

/// Returns the corner nearest to a place of a quad.
inline int nearestCorner(const glm::vec2& place) {
    return (place.x > 0.5f ? 1 : 0) + (place.y > 0.5f ? 2 : 0);
}

}  // namespace lightcook::verify::lightmap
