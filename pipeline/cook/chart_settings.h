// Settings of charts to pack or to split (pipeline/repack, pipeline/assets/light_map/chart_split.h) beside the other settings of a scene.
#pragma once

#include <string>

#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

/// Returns what is wrong with packing or splitting the charts of a light map of a scene, or an empty text.
std::string whyNotCharts(const Scene& scene, const LightMapEntry& entry);

}  // namespace lightcook::pipeline
