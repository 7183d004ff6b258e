// Colour spaces of an action's sources.
#pragma once

#include "formats/color.h"
#include "formats/environment.h"
#include "pipeline/graph/action.h"
#include "pipeline/manifest/cooked_asset.h"

namespace lightcook::pipeline {

/// Input of an action whose colours are converted by an OCIO configuration of the scene. The file is an input, so that its content counts
/// and the file may move; parameters name the spaces alone.
inline constexpr const char* kColorConfigRole = "color_config";

/// Returns the colour spaces with the configuration file of the action.
formats::ColorSpaces withConfig(const formats::ColorSpaces& colors, const Action& action);

/// Returns the options that an action reads an environment or a gradient with.
formats::EnvironmentOptions environmentOptions(const AssetSource& source, const Action& action);

}  // namespace lightcook::pipeline
