// Learns the decode of layouts "basis-K" from a sample of the map's blocks: clusters of charts, a quadratic decode for each, and linear
// residuals, each stage fitted to what the encoder really made of the one before.
#pragma once

#include "compress/light_map.h"
#include "compress/light_map/basis/model.h"

namespace lightcook::compress {

/// Assigns charts to at most clusterCount clusters (1 .. 256) and fits every cluster's tables.
/// plan    of the map: textures, range and key are read
/// charts  of the blocks that the samples were chosen from (LightMapBlocks::charts)
BasisModel fitBasis(const LightMapPlan& plan, const BasisShape& shape, const LightMapSamples& samples, const std::vector<int>& charts,
                    int blocksAcross, int clusterCount, const EncodeOptions& options);

}  // namespace lightcook::compress
