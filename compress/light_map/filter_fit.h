// Chooses values of texels at the borders of charts so that the texels, filtered and decoded by a GPU, show what the covered texels of the
// bake alone show. Private to compress/.
//
// A filter reads texels outside charts on the surface, up to half a texel beyond the outermost centres. At a place p with bilinear weights
// w_k the reference is R(p) = (sum over covered k of w_k v_k) / W(p), W(p) the sum of their weights, and the result is the sum over all
// four texels. The uncovered ones are free: they minimise the sum over places of
//   g(p)^2 |sum_k w_k v_k - R(p)|^2
// with g(p) = 1 / (exit radiance of R + a share of the key): a viewer sees about the logarithm of light. Places are four Gauss points of
// the quarter of each quad that belongs to a covered texel, so that the sum is an integral over the footprints of covered texels. Quads in
// which no surface lies (formats::mayHoldSurface) have none.
//
// Layouts that divide by coefficient 0 filter two factors: l(p) q(p). Coefficient 0 is solved first, as above. With l(p) known, ratios q
// are linear unknowns again, with weights (g l)^2 in each channel. At an edge of light that product is far from the filtered product, most
// of all on the dark side. Layout ratio and the learned layouts under the visible objective therefore fit the ratios of covered texels
// there, too. The centre of each texel weighs as much as the places of a quad, since texels are seen at their centres as well.
//
// The normal equations couple a texel to its eight neighbours. They are solved by projected Gauss-Seidel in four colours: each value is
// clamped to the range of the layout. A sweep reaches two rows, so that the result depends on a few rows beyond the encoded ones, and not
// on the strips that a map is divided into.
#pragma once

#include "compress/light_map/rows.h"
#include "compress/light_map_context.h"

namespace lightcook::compress::rows {

/// Sets the uncovered neighbours of covered texels in `source`, and the covered texels that are fitted.
/// strip     as for encodeLightMapRows
/// firstRow  of `source` in the map
void fitToFilter(const LightMapPlan& plan, const formats::LightMapStrip& strip, int firstRow, Source& source);

}  // namespace lightcook::compress::rows
