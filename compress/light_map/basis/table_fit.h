// Least squares for the table of a cluster's quadratic decode, with the codes of its texels given. Private to compress/.
//
// Minimises the sum over texels of weight (ratio - P(u))' Q (ratio - P(u)), Q the cost of errors of the texel's ratios (form_regression.h),
// by conjugate gradients on the normal equations of the 10 or 15 monomials of all channels. Two terms regularise:
// - The block encoder will move each code by noise of standard deviation kCodeNoise. Its expected effect is added to the normal matrix:
//   the variance times the outer products of the monomials' derivatives. The polynomial then does not rely on differences of codes that
//   block compression will not keep.
// - A ridge towards the table before, kRidge of the mean diagonal, for clusters of few texels.
#pragma once

#include <vector>

#include "compress/light_map/basis/sample.h"

namespace lightcook::compress {

/// Replaces the table of a cluster by the one that fits its members best, rounded to 16-bit floats.
void fitTable(const std::vector<SampleTexel*>& members, const BasisShape& shape, CodeTable& table);

}  // namespace lightcook::compress
