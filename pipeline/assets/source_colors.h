// Colour spaces of an action's sources.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

#include "formats/color.h"
#include "formats/environment.h"
#include "pipeline/assets/cooked_asset.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// Input of an action whose colours are converted by an OCIO configuration of the scene. The file is an input, so that its content counts
/// and the file may move; parameters name the spaces alone. Files that the configuration refers to are inputs "color_config-1" and so on.
inline constexpr const char* kColorConfigRole = "color_config";

/// Returns true for the role of a configuration and for those of the files that it refers to.
bool isColorConfigRole(std::string_view role);

/// Returns the inputs of an action that reads one file: "source", and the configuration of its colours with its files.
std::map<std::string, std::filesystem::path> sourceInputs(const std::filesystem::path& file, const formats::ColorSpaces& colors);
/// The same of an environment: where it is one of six files, those of the other faces too that exist, as "source-NAME".
std::map<std::string, std::filesystem::path> environmentInputs(const std::filesystem::path& file, const formats::ColorSpaces& colors);

/// Returns the colour spaces with the configuration file of the action.
formats::ColorSpaces withConfig(const formats::ColorSpaces& colors, const Action& action);

/// Returns the options that an action reads an environment or a gradient with.
formats::EnvironmentOptions environmentOptions(const AssetSource& source, const Action& action);

}  // namespace lightcook::pipeline
