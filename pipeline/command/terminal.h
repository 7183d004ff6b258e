// Messages of a running command: a progress bar on a terminal and nothing on a pipe; errors as one line each, plain or JSON.
#pragma once

#include <mutex>
#include <span>
#include <string>
#include <string_view>

#include "formats/error.h"

namespace lightcook::pipeline {

enum class LogFormat { Text, JsonLines };

class Terminal {
public:
    explicit Terminal(LogFormat format);
    ~Terminal();
    Terminal(const Terminal&) = delete;
    Terminal& operator=(const Terminal&) = delete;

    /// Draws the progress bar, at most twenty times a second. Callable from any thread.
    void progress(const std::string& what, double fraction);
    void error(const formats::Error& error);
    void warning(const std::string& subject, const std::string& detail);
    /// Prints a line of the command's result on standard output.
    void say(const std::string& line);
    bool isInteractive() const { return isInteractive_; }

private:
    void clearBar();

    std::mutex mutex_;
    LogFormat format_;
    bool isInteractive_;
    bool barIsDrawn_ = false;
    long long lastDrawnMs_ = 0;
};

struct ExitCodeInfo {
    int code;
    std::string_view meaning;
};

/// Returns every exit code with its meaning, in ascending order.
std::span<const ExitCodeInfo> allExitCodes();

/// Returns the exit code of an error.
int exitCode(formats::ErrorCode code);

}  // namespace lightcook::pipeline
