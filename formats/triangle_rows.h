// Horizontal extents of triangles in the plane, for loops over the rows of a light map.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <glm/vec2.hpp>

namespace lightcook::formats {

using Corners = std::array<glm::dvec2, 3>;  ///< [texels]

/// Horizontal extent of a triangle between two heights; right < left if the triangle does not reach there.
struct Spread {
    double left = HUGE_VAL, right = -HUGE_VAL;
    void add(double x) {
        left = std::min(left, x);
        right = std::max(right, x);
    }
};
inline Spread spreadBetween(const Corners& corners, double low, double high) {
    Spread spread;
    for (std::size_t i = 0; i < 3; ++i) {
        const glm::dvec2 &a = corners[i], &b = corners[(i + 1) % 3];
        if (low <= a.y && a.y <= high) spread.add(a.x);
        for (const double y : {low, high})
            if (a.y != b.y && std::min(a.y, b.y) <= y && y <= std::max(a.y, b.y)) spread.add(a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y)));
    }
    return spread;
}

}  // namespace lightcook::formats
