#include "pipeline/command/session.h"

#include <algorithm>
#include <csignal>
#include <thread>

namespace lightcook::pipeline {
namespace {

RunState* interruptedState = nullptr;  ///< of the one Session that runs; read by the signal handler

extern "C" void onInterrupt(int) {
    if (interruptedState != nullptr) interruptedState->interrupted = true;
}

}  // namespace

int GlobalOptions::threadCount() const {
    return threads > 0 ? threads : static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

Session::Session(const GlobalOptions& options) : terminal(options.logFormat()), threads(options.threadCount()), log(options.logFormat()) {
    state.progress = [this](const std::string& what, double fraction) { terminal.progress(what, fraction); };
    interruptedState = &state;
    std::signal(SIGINT, onInterrupt);
    std::signal(SIGTERM, onInterrupt);
}

Session::~Session() {
    interruptedState = nullptr;
}

int Session::finish(const std::vector<formats::Error>& errors) {
    for (const formats::Error& error : errors) terminal.error(error);
    return errors.empty() ? 0 : exitCode(errors.front().code);
}

}  // namespace lightcook::pipeline
