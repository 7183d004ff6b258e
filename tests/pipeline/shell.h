// Commands of a shell.
#pragma once

#include <sys/wait.h>

#include <cstdlib>
#include <sstream>
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

/// Returns what a command printed on standard error without the lines for assets that were done.
inline std::string withoutDone(const std::string& text) {
    std::string rest;
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);)
        if (line.find(": done in ") == std::string::npos) rest += line + "\n";
    return rest;
}

}  // namespace lightcook::pipeline
