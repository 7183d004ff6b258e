// Seams of light maps: steps of light between both sides of the edges that two charts share, in the bake and cooked. The charts may lie in
// different maps of a split light map.
#pragma once

#include <string>
#include <vector>

#include "pipeline/assets/light_map/compared_map.h"
#include "pipeline/assets/results.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// Measures the seams between light maps: the edges whose sides lie in different ones. There is one stage, "total": the maps may have
/// stages of their own. The result is the same on any number of threads.
formats::Result<SeamFigures> measureSeamsBetween(const LitSurface& surface, const ActionContext& context);

/// Draws the worst seams as a camera in front of each sees them, in the order of SeamFigures::worst. Steps below half of a just noticeable
/// difference get no picture.
/// name  of the files, before their numbers
formats::Result<std::vector<RenderedView>> writeSeamViews(const SeamFigures& seams, const LitSurface& surface, const ActionContext& context,
                                                          const std::string& name);

}  // namespace lightcook::pipeline
