#include "pipeline/command/terminal/interrupts.h"

#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <string>

#include "formats/temporaries.h"
#include "pipeline/report/exit_codes.h"

namespace lightcook::pipeline {
namespace {

constexpr std::array kSignals = {SIGINT, SIGTERM, SIGHUP};

// Read by the signal handler. The semaphore counts signals, and once the end of the object.
sem_t wakeUps;
std::atomic<std::atomic<bool>*> askedFlag{nullptr};
std::atomic<int> received{0};

extern "C" void onSignal(int number) {
    const int error = errno;
    if (received.fetch_add(1) > 0) {  // the second one
        ::signal(number, SIG_DFL);
        ::raise(number);
    }
    if (std::atomic<bool>* flag = askedFlag.load()) flag->store(true);
    ::sem_post(&wakeUps);
    errno = error;
}

/// Waits for a post, at most until `end`. Returns false if none came.
bool waitUntil(std::chrono::system_clock::time_point end) {
    const auto sinceEpoch = end.time_since_epoch();
    const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(sinceEpoch);
    const timespec time{seconds.count(), std::chrono::duration_cast<std::chrono::nanoseconds>(sinceEpoch - seconds).count()};
    int done = ::sem_timedwait(&wakeUps, &time);
    while (done != 0 && errno == EINTR) done = ::sem_timedwait(&wakeUps, &time);
    return done == 0;
}

/// Prints one line without the locks of stdio, which a thread may hold that waits for a full pipe; not at all if the pipe is full.
void printLine(const std::string& line) {
    pollfd standardError{STDERR_FILENO, POLLOUT, 0};
    if (::poll(&standardError, 1, 0) == 1 && (standardError.revents & POLLOUT) != 0)
        if (::write(STDERR_FILENO, line.data(), line.size()) < 0) return;
}

}  // namespace

Interrupts::Interrupts(std::atomic<bool>& asked, LogFormat log) : asked_(asked), log_(log) {
    ::sem_init(&wakeUps, 0, 0);
    ::signal(SIGXFSZ, SIG_IGN);  // a write beyond the limit on file sizes fails, and its file is named and removed
    received = 0;
    askedFlag = &asked_;
    watcher_ = std::thread([this] { watch(); });
    struct sigaction action {};
    action.sa_handler = onSignal;
    action.sa_flags = SA_RESTART;
    ::sigemptyset(&action.sa_mask);
    for (const int number : kSignals) {
        struct sigaction before {};
        ::sigaction(number, nullptr, &before);
        if (number == SIGHUP && before.sa_handler == SIG_IGN) continue;
        ::sigaction(number, &action, nullptr);
    }
}

Interrupts::~Interrupts() {
    for (const int number : kSignals) {
        struct sigaction current {};
        ::sigaction(number, nullptr, &current);
        // The command is done and the program about to end: a signal now would only hide the exit code.
        if (current.sa_handler == onSignal) ::signal(number, SIG_IGN);
    }
    isOver_ = true;
    ::sem_post(&wakeUps);
    watcher_.join();
    askedFlag = nullptr;
}

void Interrupts::watch() {
    while (::sem_wait(&wakeUps) != 0) {
    }
    if (!asked_) return;  // the object's end
    const auto end = std::chrono::system_clock::now() + kGrace;
    formats::stopOutputs();  // waits for outputs that are just appearing together
    while (!isOver_)
        if (!waitUntil(end)) break;
    if (isOver_) return;
    formats::abandonTemporaries();
    const formats::ErrorCode code = formats::ErrorCode::Interrupted;
    printLine(log_ == LogFormat::JsonLines
                  ? fmt::format(R"({{"level":"error","code":{},"subject":"lightcook","detail":"interrupted"}})"
                                "\n",
                                exitCode(code))
                  : fmt::format("{}lightcook: error: interrupted\n", ::isatty(STDERR_FILENO) == 1 ? "\r\x1b[K" : ""));
    ::_exit(exitCode(code));
}

}  // namespace lightcook::pipeline
