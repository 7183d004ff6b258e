// The option --launcher of `cook` and `plan`.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "formats/error.h"
#include "pipeline/graph/launcher.h"

namespace lightcook::pipeline {

/// Refuses what is no command in one line.
formats::Result<void> checkLauncher(const std::string& launcher);

/// Returns how actions get to other machines.
/// cacheWords   options of `work` that name the cache
formats::Result<LaunchOptions> launchOptionsOf(const std::string& launcher, const std::vector<std::string>& cacheWords);

/// Returns the first error of the last document of --json in an output that may have other lines; nothing without one.
std::optional<formats::Error> errorInOutput(const std::string& output);

}  // namespace lightcook::pipeline
