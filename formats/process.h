// These functions ask the system about this process: where its program lies, and the memory that it took. A port to another system replaces
// this file and formats/memory.h.
#pragma once

#include <sys/resource.h>

#include <cstdint>
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

/// Returns the peak resident memory of this process [bytes].
inline std::uint64_t peakResidentBytes() {
    struct rusage usage {};
    ::getrusage(RUSAGE_SELF, &usage);
    return static_cast<std::uint64_t>(usage.ru_maxrss) * 1024;
}

}  // namespace lightcook::formats
