#include "pipeline/command/terminal.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>

namespace lightcook::pipeline {
namespace {

constexpr std::array kExitCodes = {
    ExitCodeInfo{0, "success"},
    ExitCodeInfo{1, "internal error, or an error of the system, such as a full disk"},
    ExitCodeInfo{2, "mistake on the command line or in the scene file"},
    ExitCodeInfo{3, "input refused: unreadable, not finite or of the wrong shape"},
    ExitCodeInfo{4, "verification failed: an error over its limit, or a file that is not the one that was cooked"},
    ExitCodeInfo{5, "over the memory budget"},
    ExitCodeInfo{6, "interrupted"},
};

}  // namespace

using formats::ErrorCode;

std::span<const ExitCodeInfo> allExitCodes() {
    return kExitCodes;
}

Terminal::Terminal(LogFormat format) : format_(format), isInteractive_(format == LogFormat::Text && ::isatty(STDERR_FILENO) == 1) {}

Terminal::~Terminal() {
    clearBar();
}

void Terminal::clearBar() {
    if (barIsDrawn_) fmt::print(stderr, "\r\x1b[K");
    barIsDrawn_ = false;
}

void Terminal::progress(const std::string& what, double fraction) {
    if (!isInteractive_) return;
    const std::lock_guard lock(mutex_);
    const long long now =
        std::chrono::duration_cast<std::chrono::milliseconds>(std::chrono::steady_clock::now().time_since_epoch()).count();
    if (now - lastDrawnMs_ < 50 && fraction < 1) return;
    lastDrawnMs_ = now;
    constexpr int kWidth = 30;
    const int filled = static_cast<int>(std::clamp(fraction, 0.0, 1.0) * kWidth);
    fmt::print(stderr, "\r\x1b[K[{}{}] {:3.0f} % {}", std::string(static_cast<std::size_t>(filled), '#'),
               std::string(static_cast<std::size_t>(kWidth - filled), '.'), 100 * fraction, what);
    std::fflush(stderr);
    barIsDrawn_ = true;
}

void Terminal::error(const formats::Error& error) {
    const std::lock_guard lock(mutex_);
    clearBar();
    if (format_ == LogFormat::JsonLines)
        fmt::print(
            stderr, "{}\n",
            nlohmann::json({{"level", "error"}, {"code", exitCode(error.code)}, {"subject", error.subject}, {"detail", error.detail}})
                .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
    else
        fmt::print(stderr, "lightcook: error: {}\n", error.line());
}

void Terminal::warning(const std::string& subject, const std::string& detail) {
    const std::lock_guard lock(mutex_);
    clearBar();
    if (format_ == LogFormat::JsonLines)
        fmt::print(stderr, "{}\n",
                   nlohmann::json({{"level", "warning"}, {"subject", subject}, {"detail", detail}})
                       .dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
    else
        fmt::print(stderr, "lightcook: warning: {}: {}\n", subject, detail);
}

void Terminal::say(const std::string& line) {
    const std::lock_guard lock(mutex_);
    clearBar();
    fmt::print("{}\n", line);
}

int exitCode(ErrorCode code) {
    switch (code) {
        case ErrorCode::Internal:
            return 1;
        case ErrorCode::InvalidRequest:
            return 2;
        case ErrorCode::FileUnreadable:
        case ErrorCode::FormatUnsupported:
        case ErrorCode::WrongShape:
        case ErrorCode::ValueNotFinite:
        case ErrorCode::ValueOutOfRange:
        case ErrorCode::ColorSpace:
            return 3;
        case ErrorCode::Verification:
            return 4;
        case ErrorCode::OverBudget:
            return 5;
        case ErrorCode::Interrupted:
            return 6;
    }
    return 1;
}

}  // namespace lightcook::pipeline
