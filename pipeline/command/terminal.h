// What people and machines see while a command runs: a progress bar on a terminal, nothing on a pipe; errors as a line, or as JSON.
#pragma once

#include <mutex>
#include <string>

#include "formats/error.h"

namespace lightcook::pipeline {

enum class LogFormat { Text, JsonLines };

class Terminal {
public:
    explicit Terminal(LogFormat format);
    ~Terminal();
    Terminal(const Terminal&) = delete;
    Terminal& operator=(const Terminal&) = delete;

    /// From any thread; drawn at most twenty times a second.
    void progress(const std::string& what, double fraction);
    void error(const formats::Error& error);
    void warning(const std::string& subject, const std::string& detail);
    /// A line of result on standard output.
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

/// Exit code of an error: product.md's table.
int exitCode(formats::ErrorCode code);

}  // namespace lightcook::pipeline
