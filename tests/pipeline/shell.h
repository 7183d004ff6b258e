// Commands of a shell.
#pragma once

#include <sys/wait.h>

#include <cstdlib>
#include <string>

namespace lightcook::pipeline {

/// Returns the exit code of a shell command; -1 if it did not run, or if a signal ended it.
inline int runShell(const std::string& command) {
    const int status = std::system(command.c_str());
    return status == -1 || !WIFEXITED(status) ? -1 : WEXITSTATUS(status);
}

inline bool isInstalled(const std::string& program) {
    return runShell("command -v " + program + " >/dev/null 2>&1") == 0;
}

}  // namespace lightcook::pipeline
