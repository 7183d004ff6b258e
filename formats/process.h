// These functions ask the system about this process: where its program lies, and which of its descriptors a path means. A port to another
// system replaces this file and formats/memory.h.
#pragma once

#include <unistd.h>

#include <charconv>
#include <filesystem>
#include <optional>
#include <string>
#include <system_error>

#include "formats/error.h"

namespace lightcook::formats {

/// Returns the file of the running program.
inline Result<std::filesystem::path> programFile() {
    std::error_code error;
    std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
    if (error) return failure(ErrorCode::Internal, "/proc/self/exe", "found no link, expected it to tell where the program lies");
    return program;
}

/// Returns the folder of the running program.
inline Result<std::filesystem::path> programFolder() {
    return programFile().map([](const std::filesystem::path& program) { return program.parent_path(); });
}

/// Returns the folder /proc/N/fd that holds the path, if one does: its links are descriptors, which have no name to rename to.
inline std::optional<std::filesystem::path> descriptorFolder(const std::filesystem::path& path) {
    std::error_code error;
    const std::filesystem::path folder = std::filesystem::canonical(path.parent_path(), error);
    if (error || folder.filename() != "fd" || !folder.string().starts_with("/proc/")) return std::nullopt;
    return folder;
}

/// Returns the descriptor of this process that a path such as /dev/stdout names.
inline std::optional<int> ownDescriptor(const std::filesystem::path& path) {
    const auto folder = descriptorFolder(path);
    if (!folder || *folder != "/proc/" + std::to_string(::getpid()) + "/fd") return std::nullopt;
    const std::string name = path.filename().string();
    int number = -1;
    if (std::from_chars(name.data(), name.data() + name.size(), number).ec != std::errc()) return std::nullopt;
    return number;
}

}  // namespace lightcook::formats
