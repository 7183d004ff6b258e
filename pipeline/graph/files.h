// Files that the program writes: each appears whole or not at all, and an unchanged one can keep its times.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>

#include "formats/error.h"
#include "formats/pending_file.h"
#include "formats/temporary_folder.h"

namespace lightcook::pipeline {

using formats::OutputLink;
using formats::TemporaryFolder;

/// An output folder, and the files that will take the place of those in it.
struct StagedFolder {
    std::filesystem::path folder, staging;  ///< no staging: no such files

    StagedFolder(std::filesystem::path output, std::filesystem::path staged = {}) : folder(std::move(output)), staging(std::move(staged)) {}
    /// Returns the folder that has a file, by its name in both: the staging folder before the output folder.
    [[nodiscard]] const std::filesystem::path& of(const std::filesystem::path& name) const;
};

/// Writes a file beside its place, syncs it and renames it. Makes folders as needed. Replaces a symbolic link of that name, which is right
/// inside an output folder; pass OutputLink::Follow for a file that the user names.
formats::Result<void> writeFile(const std::filesystem::path& file, std::string_view content, OutputLink link = OutputLink::Replace);
formats::Result<void> writeFile(const std::filesystem::path& file, std::span<const std::byte> content,
                                OutputLink link = OutputLink::Replace);
/// Writes a file under a temporary name beside its place, which its commit() gives it. Returns none if it holds exactly this content: then
/// its times stay, as Ninja's `restat` expects.
formats::Result<std::optional<formats::PendingFile>> prepareFileIfChanged(const std::filesystem::path& file, std::string_view content);
/// Returns the content of a file.
formats::Result<std::string> readFile(const std::filesystem::path& file);
/// Returns the size of a file [bytes]; 0 if there is none.
std::uint64_t sizeOf(const std::filesystem::path& file);
/// Copies through a temporary beside the destination.
formats::Result<void> copyFile(const std::filesystem::path& source, const std::filesystem::path& destination,
                               OutputLink link = OutputLink::Replace);
/// Moves a file. A symbolic link of the destination's name is replaced.
formats::Result<void> moveFile(const std::filesystem::path& source, const std::filesystem::path& destination);
/// Makes a folder and those above it. An empty path is the current folder.
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
