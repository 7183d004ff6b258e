// Words for a folder that was named where a cooked one was meant.
#pragma once

#include <filesystem>
#include <string>

namespace lightcook::pipeline {

/// Returns "the output folder of `lightcook cook`", with the first cooked folder in `folder` as an example if there is one.
std::string expectedCookedFolder(const std::filesystem::path& folder);

}  // namespace lightcook::pipeline
