#include "pipeline/command/terminal/terminal.h"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <atomic>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "formats/system_calls.h"
#include "pipeline/report/exit_codes.h"

namespace lightcook::pipeline {
namespace {

/// Returns the number of an SGR escape sequence.
int codeOf(Style style) {
    switch (style) {
        case Style::Good:
            return 32;
        case Style::Bad:
            return 31;
        case Style::Warning:
            return 33;
        case Style::Faint:
            return 2;
        case Style::Plain:
            break;
    }
    return 0;
}

std::atomic<bool> isOutputLost{false};

/// Writes to standard output or standard error at once. There is nobody to tell that standard error cannot be written.
void print(int descriptor, std::string_view text) {
    if (!formats::writeWhole(descriptor, text) && descriptor == STDOUT_FILENO) isOutputLost = true;
}

/// Returns JSON as one line. Bytes of a file name that are not UTF-8 become U+FFFD.
std::string lineOf(const nlohmann::ordered_json& json) {
    return json.dump(-1, ' ', false, nlohmann::ordered_json::error_handler_t::replace);
}

}  // namespace

bool takesEscapes(int descriptor) {
    const char* const term = std::getenv("TERM");
    return term != nullptr && std::string_view(term) != "dumb" && ::isatty(descriptor) == 1;
}

bool Terminal::hasLostOutput() {
    return isOutputLost;
}

Terminal::Terminal(const TerminalOptions& options)
    : options_(options),
      isInteractive_(options.format == LogFormat::Text && options.verbosity != Verbosity::Quiet && ::isatty(STDERR_FILENO) == 1),
      drawsProgress_(isInteractive_ && takesEscapes(STDERR_FILENO)) {}

Terminal::~Terminal() {
    clearProgress();
}

void Terminal::clearProgress() {
    if (progressIsDrawn_) print(STDERR_FILENO, "\r\x1b[K");
    progressIsDrawn_ = false;
}

void Terminal::progress(const std::string& line) {
    if (!drawsProgress_) return;
    const std::lock_guard lock(mutex_);
    print(STDERR_FILENO, "\r\x1b[K" + line);
    progressIsDrawn_ = true;
}

bool Terminal::hasColor(int descriptor) const {
    if (options_.color != ColorChoice::Auto) return options_.color == ColorChoice::Always;
    const char* const noColor = std::getenv("NO_COLOR");
    return (noColor == nullptr || *noColor == '\0') && takesEscapes(descriptor);
}

void Terminal::printMessage(std::string_view level, Style style, const std::string& text) {
    const std::lock_guard lock(mutex_);
    clearProgress();
    if (hasColor(STDERR_FILENO))
        print(STDERR_FILENO, fmt::format("lightcook: \x1b[{}m{}:\x1b[0m {}\n", codeOf(style), level, text));
    else
        print(STDERR_FILENO, fmt::format("lightcook: {}: {}\n", level, text));
}

void Terminal::error(const formats::Error& error) {
    if (options_.format == LogFormat::Text) return printMessage("error", Style::Bad, error.line());
    const std::lock_guard lock(mutex_);
    print(STDERR_FILENO,
          lineOf({{"level", "error"}, {"code", exitCode(error.code)}, {"subject", error.subject}, {"detail", error.detail}}) + "\n");
}

void Terminal::report(std::string_view level, Style style, const std::string& subject, const std::string& detail) {
    if (options_.format == LogFormat::Text) return printMessage(level, style, formats::withoutControls(subject + ": " + detail));
    const std::lock_guard lock(mutex_);
    print(STDERR_FILENO, lineOf({{"level", std::string(level)}, {"subject", subject}, {"detail", detail}}) + "\n");
}

void Terminal::warning(const std::string& subject, const std::string& detail) {
    report("warning", Style::Warning, subject, detail);
}

void Terminal::note(const std::string& subject, const std::string& detail) {
    report("note", Style::Faint, subject, detail);
}

void Terminal::say(const StyledLine& line) {
    const std::lock_guard lock(mutex_);
    clearProgress();
    const bool isColored = hasColor(outputIsData_ ? STDERR_FILENO : STDOUT_FILENO);
    std::string shown;
    for (const auto& [style, text] : line) {
        const std::string words = formats::withoutControls(text);
        shown += isColored && style != Style::Plain ? fmt::format("\x1b[{}m{}\x1b[0m", codeOf(style), words) : words;
    }
    print(outputIsData_ ? STDERR_FILENO : STDOUT_FILENO, shown + "\n");
}

void Terminal::detail(const std::string& line) {
    jsonDetail(formats::withoutControls(line));
}

void Terminal::jsonDetail(const std::string& json) {
    const std::lock_guard lock(mutex_);
    clearProgress();
    print(STDERR_FILENO, json + "\n");
}

void Terminal::data(const std::string& text) {
    const std::lock_guard lock(mutex_);
    clearProgress();
    print(STDOUT_FILENO, text);
}

int Terminal::columns() {
    struct winsize size {};
    return ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : 80;
}

}  // namespace lightcook::pipeline
