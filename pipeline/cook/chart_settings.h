// Checks that packed and split charts fit the other settings of a scene.
#pragma once

#include "formats/error.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

/// Fails if other settings of the scene do not allow the charts of a light map to be packed or split. Fails also if a limit on charts with
/// fewer texels is given where no charts are packed.
/// asked  settings of the command line, which the scene has taken over
formats::Result<void> checkCharts(const Scene& scene, const ChartSettings& asked = {});

}  // namespace lightcook::pipeline
