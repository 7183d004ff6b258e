// Runs the program as a user would, and measures it.
#pragma once

#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

namespace lightcook::bench {

struct ProgramRun {
    double seconds = 0;             ///< wall clock
    double userSeconds = 0;         ///< processor time outside the kernel, all threads together
    std::int64_t peakRssBytes = 0;  ///< of the process
    int exitCode = 0;
};

/// Returns the path of lightcook beside this program. Throws std::runtime_error if it was not built.
inline std::filesystem::path lightcookProgram() {
    std::filesystem::path program = std::filesystem::canonical("/proc/self/exe").parent_path() / "lightcook";
    if (!std::filesystem::exists(program)) throw std::runtime_error(program.string() + " is missing: build it first");
    return program;
}

/// Returns the content of a file; nothing if it cannot be read.
inline std::string contentOf(const std::filesystem::path& file) {
    std::ostringstream content;
    content << std::ifstream(file).rdbuf();
    return content.str();
}

/// Runs a program to its end with its output in a log file. Throws std::runtime_error if no process can be started.
inline ProgramRun runProgram(const std::vector<std::string>& command, const std::filesystem::path& log) {
    std::vector<char*> arguments;
    for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    const auto start = std::chrono::steady_clock::now();
    std::fflush(nullptr);  // else the child would print our buffered lines once more
    const pid_t child = ::fork();
    if (child < 0) throw std::runtime_error("cannot start " + command.front());
    if (child == 0) {
        if (std::freopen(log.c_str(), "w", stdout) == nullptr || ::dup2(STDOUT_FILENO, STDERR_FILENO) < 0) ::_exit(127);
        ::execv(arguments.front(), arguments.data());
        ::_exit(127);
    }
    int status = 0;
    rusage usage{};
    ::wait4(child, &status, 0, &usage);
    const std::chrono::duration<double> elapsed = std::chrono::steady_clock::now() - start;
    return {elapsed.count(), static_cast<double>(usage.ru_utime.tv_sec) + 1e-6 * static_cast<double>(usage.ru_utime.tv_usec),
            usage.ru_maxrss * 1024, WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status)};
}

}  // namespace lightcook::bench
