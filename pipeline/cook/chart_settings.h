// Checks that packed and split charts fit the other settings of a scene.
#pragma once

#include <string>

#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

/// Returns what is wrong with packing or splitting the charts of a light map of a scene, or an empty text.
std::string whyNotCharts(const Scene& scene, const LightMapEntry& entry);

}  // namespace lightcook::pipeline
