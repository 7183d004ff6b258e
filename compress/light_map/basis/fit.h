// Learns the decode of the layouts basis-K from a sample of the map's blocks. Private to compress/.
//
// 1. Sample (sample.h): coefficient 0 is encoded first; everything else is fitted as ratios to its decoded values.
// 2. Clusters (clusters.h): charts whose ratios lie near one affine subspace share their tables.
// 3. Code (code_fit.h): quadratic decode and codes, fitted to each other and to the block encoder.
// 4. Residual layers (residual_fit.h), one after the other.
// Stages are fitted to the decoded texels of the stage before, not to the ideal ones.
#pragma once

#include "compress/light_map.h"
#include "compress/light_map/basis/model.h"

namespace lightcook::compress {

/// Assigns charts to at most clusterCount clusters (1 to 256) and fits the tables of every cluster.
/// plan    of the map: textures, range and key are read
BasisModel fitBasis(const LightMapPlan& plan, const BasisShape& shape, const LightMapTraining& training, int clusterCount,
                    const EncodeOptions& options);

}  // namespace lightcook::compress
