// Checks of memory before large allocations whose size an input decides. Header only: the image module is not linked with formats.
#pragma once

#include <sys/resource.h>

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <limits>
#include <string>
#include <utility>

#include "formats/error.h"

namespace lightcook::formats {

/// Memory that a process may allocate which cannot look at the machine [bytes]: a reader behind walls. 0: it looks.
inline std::uint64_t& statedMemory() {
    static std::uint64_t bytes = 0;
    return bytes;
}
inline void limitAvailableMemory(std::uint64_t bytes) {
    statedMemory() = bytes;
}

/// Returns the memory that this process can still allocate [bytes]: the least of the free memory of the machine, the rest of the control
/// group's limit, and the rest of the limit on address space (ulimit -v).
inline std::uint64_t availableMemory() {
    constexpr std::uint64_t kUnknown = std::numeric_limits<std::uint64_t>::max();
    if (statedMemory() > 0) return statedMemory();
    const auto numberIn = [](const char* file) {
        std::uint64_t number = 0;
        std::ifstream stream(file);
        return stream >> number ? number : kUnknown;
    };
    std::uint64_t available = kUnknown;
    std::ifstream machine("/proc/meminfo");
    for (std::string key, line; machine >> key; std::getline(machine, line))
        if (std::uint64_t kibibytes = 0; key == "MemAvailable:" && machine >> kibibytes) available = kibibytes << 10;
    const std::uint64_t groupLimit = numberIn("/sys/fs/cgroup/memory.max"), groupUsed = numberIn("/sys/fs/cgroup/memory.current");
    if (groupLimit != kUnknown && groupUsed != kUnknown) available = std::min(available, groupLimit - std::min(groupLimit, groupUsed));
    rlimit limit{};
    const std::uint64_t usedPages = numberIn("/proc/self/statm");
    if (::getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY && usedPages != kUnknown)
        available = std::min<std::uint64_t>(available, limit.rlim_cur - std::min<std::uint64_t>(limit.rlim_cur, usedPages * 4096));
    return available;
}

/// Refuses an input that needs more memory than there is. `subject`: the file, and the place in it that asks for so much.
inline Result<void> checkMemory(std::uint64_t bytes, const Subject& subject) {
    constexpr std::uint64_t kSmall = std::uint64_t{64} << 20;  // not worth asking
    if (bytes <= kSmall) return {};
    const std::uint64_t available = availableMemory();
    if (bytes <= available) return {};
    std::string detail = "found content that takes ";
    detail += std::to_string(bytes >> 20);
    detail += " MiB of memory, expected at most the ";
    detail += std::to_string(available >> 20);
    detail += " MiB that are free: a damaged header, or a file for a machine with more memory";
    return failure(ErrorCode::WrongShape, subject, std::move(detail));
}

}  // namespace lightcook::formats
