// Files that somebody else made and that libraries decode (OpenEXR images, everything that OpenImageIO reads, meshes of Draco) are read in
// this process, or each in a child process behind walls: a decoder that a file crashes, stops or takes over is then an error of that file.
// The program does the latter; who links the library chooses.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace lightcook::formats {

struct ReaderOptions {
    std::filesystem::path program;  ///< lightcook-read of this version
    /// A reader ends that takes so much CPU time, or twice the time without any, and tells of no progress.
    double seconds = 60;
    std::uint64_t memoryBytes = 0;  ///< that a reader may allocate; 0: what is free when it starts
};

/// Reads such files in child processes from now on; the first one starts the program. Call it while no file is open.
void readInChildProcesses(ReaderOptions options);

/// Returns the walls that stood round every child process so far: "process" and some of "limits", "privileges", "landlock", "seccomp".
/// Empty: none was needed yet. "none": files are read in this process.
std::vector<std::string> wallsOfReaders();

}  // namespace lightcook::formats
