// A command of a shell that runs beside this program, such as `srun`, which waits for a machine.
#pragma once

#include <atomic>
#include <functional>
#include <string>

#include "formats/error.h"

namespace lightcook::pipeline {

struct CommandEnd {
    int status = 0;      ///< exit status as a shell has it: 128 + N after signal N
    std::string output;  ///< standard output and standard error; of a long one the end

    /// Returns the last line of the output that has a letter; empty without one.
    std::string lastLine() const;
};

/// Runs a command in a process group of its own, with no input, and waits for it. Once interrupted, the group gets SIGTERM.
/// isEnough   told the output so far: if it returns true, the command goes on alone, and its status counts as 1
formats::Result<CommandEnd> runCommand(const std::string& command, const std::atomic<bool>& interrupted,
                                       const std::function<bool(const std::string& output)>& isEnough);

}  // namespace lightcook::pipeline
