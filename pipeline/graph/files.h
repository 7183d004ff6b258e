// Files of our own making: they appear whole or not at all, and keep their times when nothing changed.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/error.h"

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

/// A folder that goes away with its owner, whatever it holds.
class TemporaryFolder {
public:
    /// parent   made as needed; what had to be made goes again with this folder, unless something has come to lie in it
    static formats::Result<TemporaryFolder> create(const std::filesystem::path& parent);
    /// In the system's folder for such things.
    static formats::Result<TemporaryFolder> create();
    TemporaryFolder(TemporaryFolder&& other) noexcept;
    TemporaryFolder& operator=(TemporaryFolder&& other) noexcept;
    ~TemporaryFolder();
    const std::filesystem::path& path() const { return path_; }

private:
    TemporaryFolder() = default;
    std::filesystem::path path_;
    std::vector<std::filesystem::path> madeParents_;  ///< the deepest first
};

}  // namespace lightcook::pipeline
