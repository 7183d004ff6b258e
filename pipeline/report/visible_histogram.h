// A plot for report.html: how many samples of an asset have which visible error.
#pragma once

#include <cstdint>
#include <vector>

#include "pipeline/report/html.h"

namespace lightcook::pipeline {

/// Returns an SVG of the shares of samples in each octave of visible error, both axes logarithmic: filled bars for diffuse, outlined ones
/// for specular shading. A vertical rule marks the limit if it is above 0. Empty if neither has samples. diffuse, specular  counts, as
/// verify::VisibleFigures::histogram has them; others of another size count as empty
Html visibleHistogram(const std::vector<std::int64_t>& diffuse, const std::vector<std::int64_t>& specular, double limit);

}  // namespace lightcook::pipeline
