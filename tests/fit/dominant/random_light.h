// Random light of a texel for tests of fits.
#pragma once

#include <glm/geometric.hpp>

#include "lighting/radiometry.h"
#include "tests/fit/brute_force.h"

namespace lightcook::test {

inline glm::vec3 randomColor(truth::Random& random) {
    return {static_cast<float>(random.uniform()), static_cast<float>(random.uniform()), static_cast<float>(random.uniform())};
}

inline void add(lighting::ShRgb& sum, const lighting::ShRgb& other) {
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += other[i];
}

/// Up to five light sources and ambient light, as baked; every fourth texel is noise of either sign.
inline lighting::ShRgb randomLight(truth::Random& random) {
    lighting::ShRgb sh{};
    if (random.below(4) == 0) {
        for (glm::vec3& c : sh) c = 2.0f * randomColor(random) - 1.0f;
        return sh;
    }
    const int lampCount = 1 + random.below(5);
    for (int lamp = 0; lamp < lampCount; ++lamp) add(sh, lighting::projectDirectional(glm::vec3(random.direction()), randomColor(random)));
    sh[0] += static_cast<float>(2 * random.uniform()) * randomColor(random);
    return sh;
}

inline double energyOf(const lighting::ShRgb& sh) {
    double energy = 0;
    for (const glm::vec3& c : sh) energy += glm::dot(glm::dvec3(c), glm::dvec3(c));
    return energy;
}

}  // namespace lightcook::test
