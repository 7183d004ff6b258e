// Checks that packed and split charts fit the other settings of a scene.
#pragma once

#include <string>

#include "formats/error.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

/// Returns what is wrong with packing or splitting the charts of a light map of a scene, or an empty text.
std::string whyNotCharts(const Scene& scene, const LightMapEntry& entry);

/// Refuses what a scene file says of the charts of its light maps if it does not fit the other settings, and a limit on charts with fewer
/// texels where no charts are packed.
formats::Result<void> checkCharts(const Scene& scene);

}  // namespace lightcook::pipeline
