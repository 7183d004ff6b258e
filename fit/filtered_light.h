// Dominant lights fitted for the texture filter. A GPU blends the directions and intensities of neighbouring texels, so the light between
// texels is that of the bake there only if the texels are fitted together.
//
// The fit compares two lights at each place p: centre of a texel, midpoint of an edge or of a quad of covered texels of one chart.
// (d*, c*) is the light that dominantLight() finds in the filtered bake there; (d, c) is that of the filtered textures, d normalised. The
// fit minimises
//   sum_p w_p E_p,   E = |c - c*|^2 + 2 (1 - g) c . c*,   g = (1 + a |d - d*|^2)^-2,   w = k / (|c*| + floor)^2.
// E is the squared difference of two highlights over all views: g is the overlap of microfacet lobes whose half vectors are
// |d - d*| / 2 apart, exp(-|d - d*|^2 / (8 m^2)) for Beckmann. The rational g has the mean curvature of m = 0.1, 0.25 and 0.5.
// 1. Lengths. Where the directions of neighbours differ, each gets a length: the square root of its luminance over that of the brightest
//    neighbour. The filter then weighs the directions of bright texels more; without the root, blocks of texels would have directions of
//    too many lengths for their encoder. Elsewhere the length is 1. The shader normalises, so that the length has no effect at texel
//    centres.
// 2. Unknowns. Texels of quads whose middle is still off by more than `tolerance` are unknown; all others keep their light.
// 3. Block coordinate descent, a texel at a time in the order of rows, until a sweep gains less than 1 %. Intensities have a closed form.
//    Directions take a Gauss-Newton step for the tangent of E in |d - d*|^2, an upper bound as E is concave there, and keep their length.
//    Both moves are kept only if the sum falls and the texel's own centre stays within `mostAtCentre`.
#pragma once

#include <cstdint>
#include <glm/vec3.hpp>

#include "fit/dominant_light.h"
#include "formats/image.h"
#include "lighting/sh.h"

namespace lightcook::fit {

struct FilteredLightOptions {
    DominantLightOptions light;  ///< of the lights at the places
    double floor = 0;            ///< intensity added to that of each place, so that errors of dark places count absolutely
    double tolerance = 0.05;     ///< largest sqrt(E) / (|c*| + floor) at the middle of a quad whose texels are not solved
    double centreWeight = 3;     ///< k of texel centres; it is 1 between texels
    double mostAtCentre = 0.4;   ///< largest sqrt(E) / (|c*| + floor) at the centre of a solved texel
    double shortest = 0.2;       ///< least length of a direction
    double turn = 0.05;  ///< distance of unit directions from which lengths begin to change; from twice as much on they change in full
    int mostSweeps = 8;
};

/// Rows beyond the solved ones that the solution depends on, as far as the map has them.
inline constexpr int kFilteredLightMargin = 2;

/// Fits the lights of rows [firstRow, firstRow + rowCount) together; of the other rows only lengths change. Directions keep a length of at
/// most 1, intensities stay at least 0 and at most the largest of the bake around the texel. Finite for every finite input. The result
/// depends on nothing but the arguments: strips that overlap can be solved on any threads.
/// rows    with the lights of fitDominantLights(), which become those for the filter
/// solved  as large as the rows; becomes 1 where the light was unknown, else 0
void fitForFilter(const DominantLightRows& rows, formats::ImageView<std::uint8_t> solved, int firstRow, int rowCount,
                  const FilteredLightOptions& options);

}  // namespace lightcook::fit
