// Fit of the residual layers of a learned layout: a linear basis of four directions for each cluster and layer. Private to compress/.
//
// 1. Directions: the four leading principal components of the cluster's remaining ratios (error_space.h), about 0 and not their mean, so
//    that the neutral texel adds nothing. Each is scaled so that the box [0, 1] holds the coordinates up to kRangeDeviations.
// 2. The texels' numbers by least squares (solveResidual), sent through the block encoder.
// 3. The directions fitted again, to the decoded numbers.
// 4. The layer's decoded texels are subtracted from the ratios, and the next layer starts from the rest.
#pragma once

#include "compress/light_map/basis/sample.h"

namespace lightcook::compress {

/// Appends a layer to model.residual and model.residualWeights, and subtracts it from the texels' ratios.
void addResidualLayer(BasisSample& sample, BasisModel& model);

}  // namespace lightcook::compress
