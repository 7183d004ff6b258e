#include "pipeline/command/terminal/interrupts.h"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <string>

#include "formats/temporaries.h"
#include "pipeline/report/exit_codes.h"

namespace lightcook::pipeline {
namespace {

/// Sent to the watcher at the end of the object.
int overSignal() {
    return SIGRTMIN;
}

/// Prints one line without the locks of stdio, which a thread may hold that waits for a full pipe; not at all if the pipe is full.
void printLine(const std::string& line) {
    pollfd standardError{STDERR_FILENO, POLLOUT, 0};
    if (::poll(&standardError, 1, 0) == 1 && (standardError.revents & POLLOUT) != 0)
        if (::write(STDERR_FILENO, line.data(), line.size()) < 0) return;
}

}  // namespace

Interrupts::Interrupts(std::atomic<bool>& asked, LogFormat log) : asked_(asked), log_(log) {
    ::signal(SIGXFSZ, SIG_IGN);  // a write beyond the limit on file sizes fails, and its file is named and removed
    struct sigaction hangUp {};
    ::sigaction(SIGHUP, nullptr, &hangUp);
    ::sigemptyset(&signals_);
    ::sigaddset(&signals_, SIGINT);
    ::sigaddset(&signals_, SIGTERM);
    if (hangUp.sa_handler != SIG_IGN) ::sigaddset(&signals_, SIGHUP);
    sigset_t blocked = signals_;
    ::sigaddset(&blocked, overSignal());
    ::pthread_sigmask(SIG_BLOCK, &blocked, nullptr);  // the threads that begin from now on inherit it
    watcher_ = std::thread([this] { watch(); });
}

Interrupts::~Interrupts() {
    ::pthread_kill(watcher_.native_handle(), overSignal());
    watcher_.join();
}

int Interrupts::exitCodeOfSignal() const {
    return isEnd_ ? 0 : exitCode(formats::ErrorCode::Interrupted);
}

void Interrupts::watch() {
    sigset_t over;
    ::sigemptyset(&over);
    ::sigaddset(&over, overSignal());
    sigset_t any = signals_;
    ::sigaddset(&any, overSignal());
    int number = 0;
    ::sigwait(&any, &number);
    if (number == overSignal()) return;
    asked_ = true;
    ::pthread_sigmask(SIG_UNBLOCK, &signals_, nullptr);  // a second one ends the process
    formats::stopOutputs();                              // waits for outputs that are just appearing together
    const timespec grace{0, std::chrono::nanoseconds(kGrace).count()};
    if (::sigtimedwait(&over, nullptr, &grace) == overSignal()) return;
    formats::abandonTemporaries();
    const int code = exitCodeOfSignal();
    if (code != 0)
        printLine(log_ == LogFormat::JsonLines
                      ? fmt::format(R"({{"level":"error","code":{},"subject":"lightcook","detail":"interrupted"}})"
                                    "\n",
                                    code)
                      : fmt::format("{}lightcook: error: interrupted\n", takesEscapes(STDERR_FILENO) ? "\r\x1b[K" : ""));
    ::_exit(code);
}

}  // namespace lightcook::pipeline
