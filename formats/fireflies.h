// Fireflies of path-traced light maps: single texels that a rare path made far brighter than all around them.
#pragma once

#include <string>
#include <vector>

#include "formats/light_map.h"

namespace lightcook::formats {

struct Firefly {
    int x = 0, y = 0;                ///< y: row of the map
    float found = 0, brightest = 0;  ///< its light and that of its brightest neighbour: the largest channel of sh00
};

/// Covered texels of a band whose neighbours (eight; five in the band's first and last row) are covered too and none of which reaches
/// 1 / limit of its light, where nine in ten covered texels of the band have less as well. limit > 0; real bakes stay under 3.
std::vector<Firefly> findFireflies(const LightMapStrip& band, double limit);

/// Refuses the first one, or with `repair` gives each the mean of its neighbours and counts it. file: for the error.
Result<void> checkFireflies(LightMapStrip& band, double limit, bool repair, const std::string& file);

}  // namespace lightcook::formats
