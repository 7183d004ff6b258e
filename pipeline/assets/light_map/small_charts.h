// Charts of so few texels that filters read texels beside them at every place: no layout lowers the errors there much.
#pragma once

#include <glm/vec2.hpp>
#include <optional>
#include <span>
#include <vector>

#include "pipeline/assets/chart_figures.h"
#include "verify/figures.h"
#include "verify/seams.h"

namespace lightcook::pipeline {

/// Area from which a chart has places that filters do not read past [texels].
inline constexpr double kFewTexels = 16;

/// Returns the area of the chart that holds a place, or lies nearest to it in the map, if that is below kFewTexels [texels]. Triangles are
/// of one chart if they share a vertex: its position and its light-map UV. Empty for larger charts, and without triangles.
/// size   of the light map [texels]
/// place  [texels] integers are centres
std::optional<double> fewTexelsAt(std::span<const verify::SurfaceTriangle> triangles, const glm::dvec2& size, const glm::dvec2& place);

/// Returns the charts of few texels that hold the places of a stage's largest visible errors.
std::vector<FewTexels> fewTexelsOf(const verify::StageError& stage, std::span<const verify::SurfaceTriangle> triangles,
                                   const glm::dvec2& size);

}  // namespace lightcook::pipeline
