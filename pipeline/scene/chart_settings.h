// Keys `charts` and `charts_max_visible` of [output] and [[light_map]].
#pragma once

#include <optional>

#include "pipeline/scene/chart_mode.h"

namespace lightcook::pipeline {

/// Largest value of charts_max_visible.
inline constexpr double kMostChartsVisible = 100;

/// Settings of one place: [output] or a [[light_map]]. What is absent in a light map is that of the output.
struct ChartSettings {
    std::optional<ChartMode> mode;
    std::optional<double> maxVisible;  ///< visible error that fewer texels may add; 0: charts are moved only
};

}  // namespace lightcook::pipeline
