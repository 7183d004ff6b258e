// Files of our own making: they appear whole or not at all, and keep their times when nothing changed.
#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "formats/error.h"
#include "formats/pending_file.h"
#include "formats/temporary_folder.h"

namespace lightcook::pipeline {

using formats::OutputLink;
using formats::TemporaryFolder;

/// Written beside its place, synced, renamed; folders are made as needed. A symbolic link of that name is replaced by the file, as is right
/// inside an output folder. Pass OutputLink::Follow for a file that the user names.
formats::Result<void> writeFile(const std::filesystem::path& file, std::string_view content, OutputLink link = OutputLink::Replace);
formats::Result<void> writeFile(const std::filesystem::path& file, std::span<const std::byte> content,
                                OutputLink link = OutputLink::Replace);
/// The same, but a file that already holds exactly this is left alone, its times too (restat).
formats::Result<void> writeFileIfChanged(const std::filesystem::path& file, std::string_view content);
formats::Result<std::string> readFile(const std::filesystem::path& file);
/// Copies through a temporary beside the destination.
formats::Result<void> copyFile(const std::filesystem::path& source, const std::filesystem::path& destination,
                               OutputLink link = OutputLink::Replace);
/// Moves a file. A symbolic link of the destination's name is replaced.
formats::Result<void> moveFile(const std::filesystem::path& source, const std::filesystem::path& destination);
formats::Result<void> makeFolder(const std::filesystem::path& folder);
/// Makes the folders above a file of an output folder. A folder takes the place of a symbolic link among them; what the link names stays.
/// name   of the file, relative to the folder
formats::Result<void> makeFoldersOf(const std::filesystem::path& folder, const std::filesystem::path& name);
/// Returns what stands in place of one of the folders above a file: a file or a symbolic link. Nothing if all are folders or missing.
/// name   of the file, relative to the folder
std::optional<std::filesystem::path> inPlaceOfFolder(const std::filesystem::path& folder, const std::filesystem::path& name);
/// Removes a file of an output folder, if it is there. Of a symbolic link of that name only the link goes; nothing is removed behind a link
/// in place of one of the folders above it.
void removeFileOf(const std::filesystem::path& folder, const std::filesystem::path& name);
/// Removes the folders between an output folder and a file of it, from the innermost on, as far as they are empty.
/// name   of the file, relative to the folder
void removeEmptyFoldersOf(const std::filesystem::path& folder, const std::filesystem::path& name);

}  // namespace lightcook::pipeline
