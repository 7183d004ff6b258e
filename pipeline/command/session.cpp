#include "pipeline/command/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <thread>

#include "pipeline/assets/action_kind.h"
#include "pipeline/graph/files.h"
#include "pipeline/report/exit_codes.h"

namespace lightcook::pipeline {

TerminalOptions GlobalOptions::terminal() const {
    TerminalOptions options;
    options.format = logFormat();
    options.verbosity = quiet ? Verbosity::Quiet : verbose ? Verbosity::Verbose : Verbosity::Normal;
    options.color = color == "always" ? ColorChoice::Always : color == "never" ? ColorChoice::Never : ColorChoice::Auto;
    return options;
}

int GlobalOptions::threadCount() const {
    return threads > 0 ? threads : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

Session::Session(const GlobalOptions& options)
    : terminal(options.terminal()),
      threads(options.threadCount()),
      log(options.logFormat()),
      interrupts_(state.interrupted, options.logFormat()) {
    if (terminal.drawsProgress())
        state.progress = [this](const Action& action, const std::string& what, double fraction) {
            progress_.onPass(action, what, fraction);
            drawProgress();
        };
    state.event = [this](const Action& action, ActionEvent event, double seconds) { onEvent(action, event, seconds); };
    state.warning = [this](const std::string& subject, const std::string& detail) { warnOnce(subject, detail); };
    state.checkOutputs = [this](const std::vector<std::filesystem::path>& files) { return paths.checkAgainst(files, kCookedFile); };
}

int Session::finish(const std::vector<formats::Error>& found) {
    for (const formats::Error& error : found) {
        // Whatever an interrupted command could not finish fails in its turn: one line says it.
        const auto isInterrupt = [](const formats::Error& each) { return each.code == formats::ErrorCode::Interrupted; };
        if (isInterrupt(error) && std::ranges::any_of(errors, isInterrupt)) continue;
        terminal.error(error);
        errors.push_back(error);
    }
    return found.empty() ? 0 : exitCode(found.front().code);
}

formats::Result<void> Session::write(const std::filesystem::path& file, const std::string& text) {
    if (file != kStandardOutput) return writeFile(file, text, OutputLink::Follow);
    terminal.data(text);
    return {};
}

void Session::onEvent(const Action& action, ActionEvent event, double seconds) {
    progress_.onEvent(action, event);
    if (terminal.verbosity() == Verbosity::Verbose) {
        if (event == ActionEvent::Finished) terminal.detail(fmt::format("lightcook: {}: {:.2f} s", action.id, seconds));
        if (event == ActionEvent::Reused)
            terminal.detail(fmt::format("lightcook: {}: from the cache ({:.2f} s when it ran)", action.id, seconds));
        if (event == ActionEvent::Failed) terminal.detail(fmt::format("lightcook: {}: failed", action.id));
    }
    if (event != ActionEvent::Planned) drawProgress();
    sayVerified(action, event, seconds);
}

void Session::sayVerified(const Action& action, ActionEvent event, double seconds) {
    if (event != ActionEvent::Finished || terminal.drawsProgress()) return;
    if (terminal.verbosity() != Verbosity::Normal || log != LogFormat::Text) return;
    const std::lock_guard lock(secondsMutex_);
    const double all = secondsOfAssets_[action.asset] += seconds;
    if (!isOfStep(action.id, ActionStep::Verify)) return;
    secondsOfAssets_.erase(action.asset);  // the next target counts its own
    terminal.detail(fmt::format("lightcook: {}: done in {:.2f} s", action.asset, all));
}

void Session::warnOnce(const std::string& subject, const std::string& detail) {
    {
        const std::lock_guard lock(warnedMutex_);
        if (!warned_.insert(subject).second) return;
    }
    terminal.warning(subject, detail);
}

/// Draws at most twenty times a second.
void Session::drawProgress() {
    if (!terminal.drawsProgress()) return;
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    const auto now = static_cast<long long>(1000 * seconds);
    long long last = lastDrawnMs_;
    if (now - last < 50 || !lastDrawnMs_.compare_exchange_strong(last, now)) return;
    terminal.progress(progress_.line(seconds, Terminal::columns()));
}

}  // namespace lightcook::pipeline
