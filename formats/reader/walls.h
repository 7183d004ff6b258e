// Walls keep a process that decodes a file from outside from all that decoding does not need, even if the file controls it.
//
//   limits       setrlimit: address space, CPU time, descriptors, no files written, no core dump
//   privileges   no new ones (execve of a program with the set-user-ID bit), and no debugger of the same user
//   Landlock     no file can be opened, no port bound or connected (Linux 5.13; network 6.7)
//   seccomp      a list of system calls for memory, threads, time and the descriptors that are open. All others fail with EPERM: open,
//                socket, execve, fork, kill, ptrace, ... No memory becomes executable
//
// A kernel without one of them goes without it. Under the sanitizers there are only the limits that these can live with.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace lightcook::formats {

using Walls = std::uint32_t;  ///< bits of Wall
enum Wall : Walls { kLimitsWall = 1, kPrivilegesWall = 2, kLandlockWall = 4, kSeccompWall = 8 };
inline constexpr Walls kAllWalls = 15;

/// Puts up all walls that this system has, for the process that calls it and for good. Returns those that stand.
/// memoryBytes  limit on further allocations of the process; 0: none
Walls putUpWalls(std::uint64_t memoryBytes);

/// Returns true in a build with sanitizers.
bool areReadersSanitized();

/// Returns the names of walls.
std::vector<std::string> namesOfWalls(Walls walls);

}  // namespace lightcook::formats
