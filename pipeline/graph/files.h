// Files of our own making: they appear whole or not at all, and keep their times when nothing changed.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "formats/error.h"
#include "formats/temporary_folder.h"

namespace lightcook::pipeline {

/// Written beside its place, synced, renamed; folders are made as needed.
formats::Result<void> writeFile(const std::filesystem::path& file, std::string_view content);
formats::Result<void> writeFile(const std::filesystem::path& file, std::span<const std::byte> content);
/// The same, but a file that already holds exactly this is left alone, its times too (restat).
formats::Result<void> writeFileIfChanged(const std::filesystem::path& file, std::string_view content);
formats::Result<std::string> readFile(const std::filesystem::path& file);
/// Copies through a temporary beside the destination.
formats::Result<void> copyFile(const std::filesystem::path& source, const std::filesystem::path& destination);
formats::Result<void> moveFile(const std::filesystem::path& source, const std::filesystem::path& destination);
formats::Result<void> makeFolder(const std::filesystem::path& folder);

using formats::TemporaryFolder;

}  // namespace lightcook::pipeline
