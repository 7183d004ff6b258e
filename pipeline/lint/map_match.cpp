#include "pipeline/lint/map_match.h"

#include <algorithm>
#include <array>
#include <vector>

namespace lightcook::pipeline {
namespace {

constexpr int kFarthest = 255;

/// Distances to the nearest texel that the mesh reads and that holds light, in the 8-neighbourhood [texels], up to kFarthest.
std::vector<std::uint8_t> distancesTo(const TexelSet& read, const TexelSet& marked) {
    const int width = read.width(), height = read.height();
    const auto at = [&](int x, int y) {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
    };
    std::vector<std::uint8_t> distance(at(0, height), kFarthest);
    const auto lower = [&](int x, int y, int otherX, int otherY) {
        if (otherX < 0 || otherX >= width || otherY < 0 || otherY >= height) return;
        distance[at(x, y)] = static_cast<std::uint8_t>(std::min<int>(distance[at(x, y)], distance[at(otherX, otherY)] + 1));
    };
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            if (read.has(x, y) && marked.has(x, y)) distance[at(x, y)] = 0;
            lower(x, y, x - 1, y);
            for (int i = -1; i <= 1; ++i) lower(x, y, x + i, y - 1);
        }
    for (int y = height; y-- > 0;)
        for (int x = width; x-- > 0;) {
            lower(x, y, x + 1, y);
            for (int i = -1; i <= 1; ++i) lower(x, y, x + i, y + 1);
        }
    return distance;
}

}  // namespace

MapMatch matchOf(const UvRaster& raster, const TexelSet& marked) {
    const int width = marked.width(), height = marked.height();
    const std::vector<std::uint8_t> distances = distancesTo(raster.touched(), marked);
    MapMatch match;
    std::array<std::int64_t, kFarthest + 1> outside{}, lit{};
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const bool isMarked = marked.has(x, y);
            match.marked += isMarked ? 1 : 0;
            match.read += raster.read().has(x, y) ? 1 : 0;
            match.empty += raster.read().has(x, y) && !isMarked ? 1 : 0;
            if (raster.touched().has(x, y)) continue;
            const std::size_t distance =
                distances[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)];
            ++outside[distance];
            lit[distance] += isMarked ? 1 : 0;
        }
    const auto isOfMargin = [&](std::size_t distance) {
        return outside[distance] > 0 && static_cast<double>(lit[distance]) >= kOfMargin * static_cast<double>(outside[distance]);
    };
    while (match.margin + 1 < kFarthest && isOfMargin(static_cast<std::size_t>(match.margin) + 1)) ++match.margin;
    for (std::size_t distance = 2 * static_cast<std::size_t>(match.margin) + 2; distance <= kFarthest; ++distance)
        match.unread += lit[distance];
    return match;
}

}  // namespace lightcook::pipeline
