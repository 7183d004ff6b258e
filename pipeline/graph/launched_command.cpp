#include "pipeline/graph/launched_command.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstring>
#include <mutex>
#include <sstream>
#include <thread>
#include <vector>

#include "formats/spawn.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Result;
using Clock = std::chrono::steady_clock;

constexpr std::size_t kMostOutput = 64 << 10;
constexpr int kPollMs = 20;
constexpr std::chrono::milliseconds kGrace{100};  ///< of an interrupted command, less than that of Interrupts

/// Starts a shell whose output goes into a descriptor.
Result<pid_t> start(const std::string& command, int output) {
    formats::SpawnFiles files;
    files.giveNothing(STDIN_FILENO);
    for (const int stream : {STDOUT_FILENO, STDERR_FILENO}) files.give(output, stream);
    const auto [child, fault] = formats::spawn("/bin/sh", {"sh", "-c", command}, files);
    if (fault != 0) return failure(ErrorCode::Internal, "/bin/sh", fmt::format("found {}, expected to start it", std::strerror(fault)));
    return child;
}

/// Appends what a descriptor has now. Returns false at its end.
bool drain(int descriptor, std::string& output) {
    std::array<char, 4096> piece{};
    while (true) {
        const ssize_t count = ::read(descriptor, piece.data(), piece.size());
        if (count < 0) return errno == EAGAIN || errno == EINTR;
        if (count == 0) return false;
        output.append(piece.data(), static_cast<std::size_t>(count));
        if (output.size() > 2 * kMostOutput) output.erase(0, output.size() - kMostOutput);
    }
}

/// Reads what a command still prints, which would wait else, and lets the system forget it.
void letEnd(pid_t child, int output) {
    pollfd waited{output, POLLIN, 0};
    std::string dropped;
    while (::poll(&waited, 1, -1) > 0 && drain(output, dropped)) {
    }
    ::waitpid(child, nullptr, 0);
    ::close(output);
}

}  // namespace

std::string CommandEnd::lastLine() const {
    std::istringstream lines(output);
    std::string last;
    for (std::string line; std::getline(lines, line);)
        if (line.find_first_not_of(" \t\r") != std::string::npos) last = line;
    return last;
}

Result<CommandEnd> runCommand(const std::string& command, const std::atomic<bool>& interrupted,
                              const std::function<bool(const std::string& output)>& isEnough) {
    static std::mutex starting;  // else a command would inherit the pipe of another one
    std::array<int, 2> ends{};
    Result<pid_t> child = 0;
    {
        const std::lock_guard lock(starting);
        if (::pipe(ends.data()) != 0)
            return failure(ErrorCode::Internal, "pipe", fmt::format("found {}, expected a pipe", std::strerror(errno)));
        for (const int end : ends) ::fcntl(end, F_SETFD, FD_CLOEXEC);
        child = start(command, ends[1]);
        ::close(ends[1]);
    }
    if (!child) {
        ::close(ends[0]);
        return tl::make_unexpected(child.error());
    }
    ::fcntl(ends[0], F_SETFL, O_NONBLOCK);
    CommandEnd end;
    int status = 0;
    bool isOpen = true, isStopped = false;
    Clock::time_point stopped;
    // The command may leave a process that holds the pipe open, as the master of an ssh connection does: the end of the shell counts.
    while (::waitpid(*child, &status, WNOHANG) == 0) {
        if (interrupted && !isStopped) {
            ::kill(-*child, SIGTERM);
            isStopped = true;
            stopped = Clock::now();
        } else if (isStopped && Clock::now() - stopped > kGrace) {
            ::kill(-*child, SIGKILL);
        }
        pollfd waited{isOpen ? ends[0] : -1, POLLIN, 0};
        // After its end the pipe is always ready.
        ::poll(&waited, 1, isOpen ? kPollMs : 1);
        const std::size_t before = end.output.size();
        if (isOpen) isOpen = drain(ends[0], end.output);
        if (end.output.size() != before && isEnough(end.output)) {
            std::thread([child = *child, output = ends[0]] { letEnd(child, output); }).detach();
            end.status = 1;
            return end;
        }
    }
    if (isOpen) drain(ends[0], end.output);
    ::close(ends[0]);
    end.status = WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
    return end;
}

}  // namespace lightcook::pipeline
