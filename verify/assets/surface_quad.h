// Quads of texels that a surface lies between. Private to verify/.
#pragma once

#include "formats/light_map.h"

namespace lightcook::verify {

/// Returns true if a surface lies between four texels of a strip, of which (x, y) is the first: all are covered, and of one chart. Packed
/// charts touch, and what a filter blends of two of them is seen nowhere.
/// y  row of the strip, not of the map; the strip has the texels to the right and below
inline bool holdsSurface(const formats::LightMapStrip& strip, int x, int y) {
    for (int corner = 0; corner < 4; ++corner)
        if (strip.covered.at(x + corner % 2, y + corner / 2) == 0) return false;
    return strip.chart.width() == 0 || formats::mayHoldSurface({strip.chart.at(x, y), strip.chart.at(x + 1, y), strip.chart.at(x, y + 1),
                                                                strip.chart.at(x + 1, y + 1)});
}

}  // namespace lightcook::verify
