// Fills texels outside charts, as far as a filter or a block reaches over the edge of a chart.
#pragma once

#include <cstdint>
#include <cstdlib>

#include "formats/image.h"

namespace lightcook::formats {

/// Calls add(x, y) for every covered texel on the smallest square ring around (centreX, centreY) that has any. Rings are 1 .. largestRing
/// texels away and are walked row by row, so that sums have one order. Returns the number of calls; 0: no covered texel within reach.
template <class Add>
int visitNearestCovered(ImageView<const std::uint8_t> covered, int centreX, int centreY, int largestRing, Add add) {
    for (int ring = 1; ring <= largestRing; ++ring) {
        int count = 0;
        for (int y = centreY - ring; y <= centreY + ring; ++y) {
            if (y < 0 || y >= covered.height) continue;
            const int step = std::abs(y - centreY) == ring ? 1 : 2 * ring;
            for (int x = centreX - ring; x <= centreX + ring; x += step) {
                if (x < 0 || x >= covered.width || covered.at(x, y) == 0) continue;
                add(x, y);
                ++count;
            }
        }
        if (count > 0) return count;
    }
    return 0;
}

}  // namespace lightcook::formats
