// SIGINT, SIGTERM and SIGHUP while a command runs.
//
// A signal first asks: from then on no output appears, and loops that look at RunState::interrupted end. A command that has not ended
// within kGrace is ended from here, whatever it does (a library may be decoding a file for a minute): its temporary files and folders are
// removed, and the process exits with the code of an interrupt. So no loop has to look at a flag for the process to end in time. A second
// signal ends the process at once, as it does without this class.
#pragma once

#include <semaphore.h>

#include <atomic>
#include <chrono>
#include <thread>

#include "pipeline/command/terminal/terminal.h"

namespace lightcook::pipeline {

/// Watches for the signals while it exists. Only one object at a time may. SIGHUP stays ignored where it was (nohup).
class Interrupts {
public:
    static constexpr std::chrono::milliseconds kGrace{200};

    /// asked  set by the first signal
    Interrupts(std::atomic<bool>& asked, LogFormat log);
    ~Interrupts();
    Interrupts(const Interrupts&) = delete;
    Interrupts& operator=(const Interrupts&) = delete;

private:
    void watch();

    std::atomic<bool>& asked_;
    LogFormat log_;
    std::atomic<bool> isOver_{false};  ///< the object is being destroyed
    std::thread watcher_;              ///< the last member: it reads the others
};

}  // namespace lightcook::pipeline
