// Messages of a running command: one line of progress on a terminal and nothing on a pipe; errors as one line each, plain or JSON.
// Names in a message may hold control characters. Lines show them as escapes (formats::withoutControls).
#pragma once

#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "formats/error.h"

namespace lightcook::pipeline {

enum class LogFormat { Text, JsonLines };

/// Quiet: errors, warnings, and what the command was asked for. Verbose: also a line for each action.
enum class Verbosity { Quiet, Normal, Verbose };

/// Auto: on a terminal, unless NO_COLOR is set or TERM is "dumb".
enum class ColorChoice { Auto, Always, Never };

/// Meaning of a piece of text, which colour supports on terminals.
enum class Style { Plain, Good, Bad, Warning, Faint };

/// A piece of a line, with its meaning.
struct StyledText {
    Style style = Style::Plain;
    std::string text;
};
using StyledLine = std::vector<StyledText>;

struct TerminalOptions {
    LogFormat format = LogFormat::Text;
    Verbosity verbosity = Verbosity::Normal;
    ColorChoice color = ColorChoice::Auto;
};

/// Returns true if a stream is a terminal that knows escape sequences: TERM is set, and not "dumb".
bool takesEscapes(int descriptor);

class Terminal {
public:
    explicit Terminal(const TerminalOptions& options);
    explicit Terminal(LogFormat format) : Terminal(TerminalOptions{format, Verbosity::Normal, ColorChoice::Auto}) {}
    ~Terminal();
    Terminal(const Terminal&) = delete;
    Terminal& operator=(const Terminal&) = delete;

    /// Returns true if the line of progress is drawn: on a terminal that knows escape sequences.
    bool drawsProgress() const { return drawsProgress_; }
    /// Draws the line of progress, where it is drawn. Callable from any thread.
    void progress(const std::string& line);
    void error(const formats::Error& error);
    void warning(const std::string& subject, const std::string& detail);
    /// Prints what may be right as it is.
    void note(const std::string& subject, const std::string& detail);
    /// Prints a line of the command's result, on a terminal in the colours of its pieces.
    void say(const StyledLine& line);
    void say(const std::string& line) { say(StyledLine{{Style::Plain, line}}); }
    /// Prints a line about the run on standard error.
    void detail(const std::string& line);
    /// Prints a JSON document about the run on standard error, exactly.
    void jsonDetail(const std::string& json);
    /// Prints text for programs on standard output, exactly.
    void data(const std::string& text);
    /// Prints the lines of say() on standard error from now on: standard output is for data().
    void keepOutputForData() { outputIsData_ = true; }

    bool isInteractive() const { return isInteractive_; }
    Verbosity verbosity() const { return options_.verbosity; }
    LogFormat format() const { return options_.format; }
    /// Returns true if something could not be written to standard output.
    static bool hasLostOutput();
    /// Returns the width of the terminal [characters].
    static int columns();

private:
    bool hasColor(int descriptor) const;
    void clearProgress();
    void report(std::string_view level, Style style, const std::string& subject, const std::string& detail);
    void printMessage(std::string_view level, Style style, const std::string& text);

    std::mutex mutex_;
    TerminalOptions options_;
    bool isInteractive_, drawsProgress_;
    bool progressIsDrawn_ = false, outputIsData_ = false;
};

}  // namespace lightcook::pipeline
