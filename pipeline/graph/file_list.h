// Lists of the files that a command wrote into a folder of the user, kept in that folder: a later run replaces these and no others.
#pragma once

#include <filesystem>
#include <optional>
#include <set>
#include <string>

namespace lightcook::pipeline {

/// Names of files, relative to the folder of their list.
using FileNames = std::set<std::string>;

/// Returns the text of a list.
std::string listText(const FileNames& names);
/// Returns the names in a list. Nothing if there is none, or a damaged one: each name stays inside the folder.
std::optional<FileNames> readFileList(const std::filesystem::path& list);

}  // namespace lightcook::pipeline
