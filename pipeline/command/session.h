// The run of a command: global options, terminal, state that a signal interrupts, exit code.
#pragma once

#include <atomic>
#include <chrono>
#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "formats/error.h"
#include "pipeline/command/outputs.h"
#include "pipeline/command/terminal/interrupts.h"
#include "pipeline/command/terminal/progress.h"
#include "pipeline/command/terminal/terminal.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// Options that stand before or after any command.
struct GlobalOptions {
    std::string log = "text";             ///< kLogFormats
    std::string color = "auto";           ///< auto, always or never
    int threads = 0;                      ///< 0: one for each core
    std::string instructions = "widest";  ///< widest or avx2
    bool quiet = false, verbose = false;
    bool noSandbox = false;  ///< foreign files are read in this process: formats/foreign_files.h

    LogFormat logFormat() const { return log == "json" ? LogFormat::JsonLines : LogFormat::Text; }
    TerminalOptions terminal() const;
    /// Returns the number of threads that the command may use, at least 1.
    int threadCount() const;
};

/// A path that stands for standard output.
inline constexpr std::string_view kStandardOutput = "-";

/// One run of a command. A signal interrupts it while it exists.
class Session {
public:
    explicit Session(const GlobalOptions& options);
    Session(const Session&) = delete;
    Session& operator=(const Session&) = delete;

    /// Prints the errors and returns the exit code of the first one, or 0.
    int finish(const std::vector<formats::Error>& errors);
    template <class T>
    int finish(const formats::Result<T>& result) {
        return result ? 0 : finish(std::vector<formats::Error>{result.error()});
    }

    /// Writes a file, or standard output if its name is "-".
    formats::Result<void> write(const std::filesystem::path& file, const std::string& text);

    /// Takes a signal for the ordinary end of the command from now on.
    void endOnSignal() { interrupts_.takeForEnd(); }
    /// Returns the exit code after a signal.
    int exitCodeOfSignal() const { return interrupts_.exitCodeOfSignal(); }

    Terminal terminal;
    RunState state;
    int threads;
    LogFormat log;
    CommandPaths paths;                       ///< of the command line
    std::vector<formats::Error> errors = {};  ///< that finish() printed
    bool hasWrittenDocuments = false;         ///< the command came to the point where it writes --json, with errors or without

private:
    void onEvent(const Action& action, ActionEvent event, double seconds);
    void warnOnce(const std::string& subject, const std::string& detail);
    void drawProgress();
    /// Prints a line for an asset that was verified, where no line of progress is drawn. One that the cache had gets none.
    void sayVerified(const Action& action, ActionEvent event, double seconds);

    std::mutex warnedMutex_;
    std::set<std::string> warned_;  ///< subjects
    Progress progress_;
    std::mutex secondsMutex_;
    std::map<std::string, double> secondsOfAssets_;  ///< of the actions that ran
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
    std::atomic<long long> lastDrawnMs_{-1000};
    Interrupts interrupts_;  ///< the last member: it reads the others
};

}  // namespace lightcook::pipeline
