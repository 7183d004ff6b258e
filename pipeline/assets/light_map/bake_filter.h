// The filter by which the light of a bake is found between texel centres: bilinear, between covered texels alone.
#pragma once

#include <algorithm>
#include <glm/common.hpp>
#include <glm/vec2.hpp>

#include "formats/light_map.h"

namespace lightcook::pipeline {

/// Calls visit(x, row, weight) for the covered ones of the four texels around a place, with their bilinear weights. They add up to less
/// than 1 where some are not covered.
/// at   in texels of the map; integers are texel centres. The strip has the rows around it, as far as the map has them
/// row  of the strip
template <class Visit>
void forEachCoveredAround(const formats::LightMapStrip& strip, const glm::dvec2& at, Visit visit) {
    const glm::dvec2 corner = glm::floor(at), part = at - corner;
    for (int i = 0; i < 4; ++i) {
        const int dx = i % 2, dy = i / 2;
        const int x = std::clamp(static_cast<int>(corner.x) + dx, 0, strip.sh.width() - 1),
                  row = std::clamp(static_cast<int>(corner.y) + dy - strip.firstRow, 0, strip.sh.height() - 1);
        const double weight = (dx == 1 ? part.x : 1 - part.x) * (dy == 1 ? part.y : 1 - part.y);
        if (weight > 0 && strip.covered.at(x, row) != 0) visit(x, row, weight);
    }
}

}  // namespace lightcook::pipeline
