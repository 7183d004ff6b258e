// The run of a command: global options, terminal, state that a signal interrupts, exit code.
#pragma once

#include <string>
#include <vector>

#include "formats/error.h"
#include "pipeline/command/terminal.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// Options that stand before or after any command.
struct GlobalOptions {
    std::string log = "text";             ///< kLogFormats
    int threads = 0;                      ///< 0: one for each core
    std::string instructions = "widest";  ///< widest or avx2

    LogFormat logFormat() const { return log == "json" ? LogFormat::JsonLines : LogFormat::Text; }
    /// Returns the number of threads that the command may use, at least 1.
    int threadCount() const;
};

/// One run of a command. SIGINT and SIGTERM set state.interrupted while it exists.
class Session {
public:
    explicit Session(const GlobalOptions& options);
    ~Session();
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    /// Prints the errors and returns the exit code of the first one, or 0.
    int finish(const std::vector<formats::Error>& errors);
    template <class T>
    int finish(const formats::Result<T>& result) {
        return result ? 0 : finish(std::vector<formats::Error>{result.error()});
    }

    Terminal terminal;
    RunState state;
    int threads;
    LogFormat log;
};

}  // namespace lightcook::pipeline
