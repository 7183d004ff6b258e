// Paths as people write them, in a scene file or on a command line.
#pragma once

#include <filesystem>
#include <string>

namespace lightcook::pipeline {

/// Returns what is wrong with a path that begins with "~", which only a shell expands, and only at the beginning of a word: here it would
/// be a folder of that name. Empty: nothing.
std::string faultOfHome(const std::string& path);

/// Returns the same of a path to read, where '\' may also stand between folders, as on Windows, and no file has such a name.
/// file  that the path means
std::string faultOfInput(const std::string& path, const std::filesystem::path& file);

}  // namespace lightcook::pipeline
