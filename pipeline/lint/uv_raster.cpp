#include "pipeline/lint/uv_raster.h"

#include <algorithm>
#include <bit>
#include <cmath>

namespace lightcook::pipeline {

std::int64_t TexelSet::count() const {
    std::int64_t sum = 0;
    for (const std::uint64_t word : bits_) sum += std::popcount(word);
    return sum;
}

void UvRaster::add(const std::array<glm::dvec2, 3>& uvs) {
    const int width = read_.width(), height = read_.height();
    // Centres of texels at whole numbers.
    std::array<glm::dvec2, 3> corners;
    for (std::size_t i = 0; i < 3; ++i) corners[i] = uvs[i] * glm::dvec2(width, height) - 0.5;
    const auto [top, bottom] = std::minmax({corners[0].y, corners[1].y, corners[2].y});
    const int first = static_cast<int>(std::ceil(std::clamp(top + kEdge, 0.0, 1.0 * height)));
    const int last = static_cast<int>(std::floor(std::clamp(bottom - kEdge, -1.0, height - 1.0)));
    for (int y = first; y <= last; ++y) {
        double low = HUGE_VAL, high = -HUGE_VAL;  // where the row crosses the edges
        for (std::size_t i = 0; i < 3; ++i) {
            const glm::dvec2 &a = corners[i], &b = corners[(i + 1) % 3];
            if ((a.y > y) == (b.y > y)) continue;
            const double x = a.x + (b.x - a.x) * (y - a.y) / (b.y - a.y);
            low = std::min(low, x);
            high = std::max(high, x);
        }
        const double from = std::ceil(std::max(low + kEdge, 0.0)), to = std::floor(std::min(high - kEdge, width - 1.0));
        if (!(from <= to)) continue;
        visits_ += static_cast<std::int64_t>(to - from) + 1;
        for (int x = static_cast<int>(from); x <= static_cast<int>(to); ++x) {
            if (read_.has(x, y)) shared_.add(x, y);
            read_.add(x, y);
            touched_.add(x, y);
        }
    }
    for (std::size_t i = 0; i < 3; ++i) addEdge(corners[i] + 0.5, corners[(i + 1) % 3] + 0.5);
}

/// Marks the texels along an edge as touched, at steps of half a texel.
/// from, to  [texels]
void UvRaster::addEdge(const glm::dvec2& from, const glm::dvec2& to) {
    const glm::dvec2 size(touched_.width(), touched_.height()), along = to - from;
    double first = 0, last = 1;  // the part within the map
    for (int axis = 0; axis < 2; ++axis) {
        if (along[axis] == 0) {
            if (!(from[axis] >= 0 && from[axis] < size[axis])) return;
            continue;
        }
        const auto [enter, leave] = std::minmax({-from[axis] / along[axis], (size[axis] - from[axis]) / along[axis]});
        first = std::max(first, enter);
        last = std::min(last, leave);
    }
    if (!(first <= last)) return;
    const double length = std::max(std::abs(along.x), std::abs(along.y)) * (last - first);
    const int steps = static_cast<int>(std::ceil(2 * length)) + 1;
    visits_ += steps / 8;
    for (int step = 0; step <= steps; ++step) {
        const glm::dvec2 at = from + along * (first + (last - first) * step / steps);
        const int x = static_cast<int>(std::floor(at.x)), y = static_cast<int>(std::floor(at.y));
        if (x >= 0 && x < touched_.width() && y >= 0 && y < touched_.height()) touched_.add(x, y);
    }
}

}  // namespace lightcook::pipeline
