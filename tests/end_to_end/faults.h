// What faults.cpp, in the process whose calls fail, shares with the test that started it.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

namespace lightcook::faults {

/// Kinds of calls that can fail.
enum Kind {
    Alloc,   ///< malloc and the like, and so operator new
    Open,    ///< of files and folders
    Read,    ///< pread too
    Write,   ///< sendfile too
    Sync,    ///< fsync and ftruncate
    Rename,  ///< mkdir and symlink too
    Map,     ///< mmap
    Thread,  ///< pthread_create
    kKinds
};
inline constexpr const char* kKindNames[kKinds] = {"alloc", "open", "read", "write", "sync", "rename", "map", "thread"};

/// The mapped file. Zeros at first.
struct FaultFile {
    std::atomic<std::uint64_t> calls[kKinds];
    std::atomic<std::uint64_t> failed;                 ///< calls that were made to fail
    std::uint64_t stackCount;                          ///< of the next member
    std::uint64_t firstOfStack[std::size_t{1} << 17];  ///< allocations that were the first of their call stack, from 1, ascending
};

}  // namespace lightcook::faults
