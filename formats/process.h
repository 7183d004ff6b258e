// These functions ask the system where the program of this process lies. A port to another system replaces this file and formats/memory.h.
#pragma once

#include <filesystem>
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

}  // namespace lightcook::formats
