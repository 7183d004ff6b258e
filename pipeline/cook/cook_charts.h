// A cook whose command line says what happens to the charts of light maps.
#pragma once

#include "pipeline/cook/cook.h"
#include "pipeline/scene/chart_settings.h"

namespace lightcook::pipeline {

/// Cooks the scene file of the options. Its charts are those of the scene file, less what the overrides give.
Outcome cookScene(const CookOptions& options, const ChartSettings& overrides, const RunState& state);

}  // namespace lightcook::pipeline
