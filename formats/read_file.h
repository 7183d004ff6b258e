// Whole files in memory. Folders, FIFOs, devices and files beyond a limit are refused before a byte is read.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "formats/error.h"

namespace lightcook::formats {

/// No text that lightcook reads is nearly as long: scenes, probe lists, manifests and reports stay below 10 MiB.
inline constexpr std::uint64_t kMostTextBytes = std::uint64_t{256} << 20;

Result<std::vector<std::byte>> readWholeFile(const std::filesystem::path& file);
Result<std::string> readWholeText(const std::filesystem::path& file, std::uint64_t mostBytes = kMostTextBytes);

}  // namespace lightcook::formats
