// Cooked folders by the folder that was named.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace lightcook::pipeline {

/// Returns "the output folder of `lightcook cook`", with the first cooked folder in `folder` as an example if there is one.
std::string expectedCookedFolder(const std::filesystem::path& folder);

/// Returns the folders of the targets in a folder, in the order of all targets; the folder itself if it is a cooked one or has none.
std::vector<std::filesystem::path> targetFolders(const std::filesystem::path& folder);

}  // namespace lightcook::pipeline
