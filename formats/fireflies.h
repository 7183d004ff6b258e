// Fireflies of path-traced light maps: single texels that one rare path made far brighter than all of their neighbours.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "formats/light_map.h"

namespace lightcook::formats {

struct Firefly {
    int x = 0, y = 0;  ///< y: row of the map
    int colour = 0;    ///< the largest one of sh00: 0 red, 1 green, 2 blue
    float found = 0;   ///< the largest colour of sh00
    float beside = 0;  ///< light that it is compared with
    double ratio = 0;  ///< most that `found` may be of `beside`
    bool isRim = false;
};

/// Finds the fireflies of a strip: covered texels that are brighter than `limit` times their brightest neighbour and brighter than nine in
/// ten covered texels of the strip. At rims, where not all neighbours are covered (eight; five in the first and last row of the strip),
/// they are brighter than limit^3 times both: light sources of few texels are kept there, and a texel of 1e30, beside which all other light
/// would be stored as 0, is not. limit  > 0; the ratio stays under 3 in bakes without fireflies
std::vector<Firefly> findFireflies(const LightMapStrip& strip, double limit);

/// Fails at the first firefly or, with `repair`, replaces each by the mean of its neighbours and counts it.
/// placeOf  returns a texel's place in the file, for the error
Result<void> checkFireflies(LightMapStrip& strip, double limit, bool repair, const std::function<Subject(const Firefly&)>& placeOf);

}  // namespace lightcook::formats
