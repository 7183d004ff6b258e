// SIGINT, SIGTERM and SIGHUP while a command runs.
//
// Every thread blocks them, and one waits for them. A signal first asks: from then on no output appears, and loops that look at
// RunState::interrupted end. A command that has not ended within kGrace is ended from here, whatever it does (a library may be decoding a
// file for a minute): its temporary files and folders are removed, and the process exits with the code of an interrupt. So no loop has to
// look at a flag for the process to end in time. A second signal ends the process at once.
#pragma once

#include <atomic>
#include <chrono>
#include <csignal>
#include <thread>

#include "pipeline/command/terminal/terminal.h"

namespace lightcook::pipeline {

/// Watches for the signals while it exists. Only one object at a time may. SIGHUP stays ignored where it was (nohup).
class Interrupts {
public:
    static constexpr std::chrono::milliseconds kGrace{200};

    /// asked  set by the first signal
    Interrupts(std::atomic<bool>& asked, LogFormat log);
    /// The signals stay blocked: the program is about to end, and one now would only hide the exit code.
    ~Interrupts();
    Interrupts(const Interrupts&) = delete;
    Interrupts& operator=(const Interrupts&) = delete;

    /// Takes a signal for the ordinary end of the command from now on, as that of a server.
    void takeForEnd() { isEnd_ = true; }
    /// Returns the exit code after a signal.
    int exitCodeOfSignal() const;

private:
    void watch();

    std::atomic<bool>& asked_;
    LogFormat log_;
    std::atomic<bool> isEnd_{false};
    sigset_t signals_;
    std::thread watcher_;  ///< the last member: it reads the others
};

}  // namespace lightcook::pipeline
