#include "formats/reader/reader_server.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <cstdlib>
#include <new>
#include <set>

#include "formats/memory.h"
#include "formats/reader/walls.h"
#include "formats/system_calls.h"

namespace lightcook::formats {
namespace {

void closeFrom(unsigned first) {
    if (::syscall(SYS_close_range, first, ~0U, 0) == 0) return;
    for (int number = static_cast<int>(first), end = static_cast<int>(::sysconf(_SC_OPEN_MAX)); number < end; ++number) ::close(number);
}

/// Ends a reader without memory. Allocates nothing: called by operator new, at any depth of a library.
[[noreturn]] void endWithoutMemory() {
    sendFrame(kReaderSocket, FrameType::OutOfMemory, {});
    ::_exit(0);
}

void sendError(const Error& error) {
    WireWriter content;
    content.put(error.code);
    content.put(std::string_view(error.subject));
    content.put(std::string_view(error.detail));
    content.put(std::string_view(error.file.native()));
    sendFrame(kReaderSocket, FrameType::Failure, content.bytes());
}

/// The memory that the program reads results from.
class WritableWindow {
public:
    bool map(int descriptor, std::size_t bytes) {
        if (bytes_ > 0) ::munmap(place_, bytes_);
        bytes_ = 0;
        place_ = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
        if (place_ == MAP_FAILED) return false;
        bytes_ = bytes;
        return true;
    }
    std::span<std::byte> bytes() const { return {static_cast<std::byte*>(place_), bytes_}; }

private:
    void* place_ = nullptr;
    std::size_t bytes_ = 0;
};

/// A reader: serves one file until the program closes the socket.
[[noreturn]] void readFile(const ReaderProgram& program, ForeignKind kind, std::uint64_t memory, const std::filesystem::path& path) {
    const ForeignInput input{kReaderFile, path};
    std::set_new_handler(endWithoutMemory);
    limitAvailableMemory(memory);
    if (kind == ForeignKind::Image) program.beforeWalls(input);
    const Walls walls = putUpWalls(memory);
    const auto decoder = program.decoders.at(static_cast<std::size_t>(kind))(input);
    WritableWindow window;
    while (auto frame = receiveFrame(kReaderSocket)) {
        if (frame->type == FrameType::Window) {
            WireReader arguments(std::move(frame->content));
            if (frame->descriptors.size() != 1 || !window.map(frame->descriptors.front().number(), arguments.get<std::uint64_t>()))
                endWithoutMemory();
            continue;
        }
        const bool opens = frame->type == FrameType::Open;
        WireReader arguments(std::move(frame->content));
        WireWriter answer;
        if (opens) answer.put(walls);
        const Result<void> done = opens ? decoder->open(arguments, answer) : decoder->read(arguments, window.bytes());
        if (done)
            sendFrame(kReaderSocket, FrameType::Answer, answer.bytes());
        else
            sendError(done.error());
    }
    ::_exit(0);  // destructors might run over objects that the file has damaged
}

/// Forks a reader. Returns its process, or 0 with the cause in errno.
pid_t forkReader(const ReaderProgram& program, Frame& request) {
    WireReader arguments(std::move(request.content));
    const auto kind = arguments.get<ForeignKind>();
    const auto memory = arguments.get<std::uint64_t>();
    const std::filesystem::path path = arguments.text();
    if (!arguments.isWhole() || static_cast<std::size_t>(kind) >= kForeignKinds || request.descriptors.size() != 2) {
        errno = EINVAL;
        return 0;
    }
    const pid_t server = ::getpid(), reader = ::fork();
    if (reader != 0) return reader < 0 ? 0 : reader;
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != server) ::_exit(0);
    // Out of the way first: one of them may have the number of the other.
    const int socket = ::fcntl(request.descriptors[0].number(), F_DUPFD, kReaderFile + 1);
    const int file = ::fcntl(request.descriptors[1].number(), F_DUPFD, kReaderFile + 1);
    ::dup2(socket, kReaderSocket);
    ::dup2(file, kReaderFile);
    ::close(kServerSocket);
    closeFrom(kReaderFile + 1);
    try {
        readFile(program, kind, memory, path);
    } catch (const std::bad_alloc&) {
        endWithoutMemory();
    }  // any other exception ends the process as a crash does
}

void answerProgram(FrameType type, int number) {
    WireWriter answer;
    answer.put(static_cast<std::int32_t>(number));
    sendFrame(kServerSocket, type, answer.bytes());
}

/// Takes note of the end of processes that were told to.
void reap(std::set<pid_t>& ending) {
    for (auto each = ending.begin(); each != ending.end();)
        each = ::waitpid(*each, nullptr, WNOHANG) == 0 ? std::next(each) : ending.erase(each);
}

}  // namespace

void reportProgress() {
    using Clock = std::chrono::steady_clock;
    static Clock::time_point last = Clock::now();
    if (Clock::now() - last < std::chrono::milliseconds(500)) return;
    last = Clock::now();
    sendFrame(kReaderSocket, FrameType::Progress, {});
}

int serveReaders(ReaderFamily family, const ReaderProgram& program) {
    for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGPIPE}) ::signal(number, SIG_IGN);  // the program decides when it ends
    closeFrom(kServerSocket + 1);
    // The kernel ends readers first when the machine's memory runs out.
    const Descriptor score(::open("/proc/self/oom_score_adj", O_WRONLY | O_CLOEXEC));
    if (score.isOpen()) writeWhole(score.number(), "1000");
    if (const auto prepared = program.prepare(family); !prepared) {
        WireWriter content;
        content.put(std::string_view(prepared.error().subject));
        content.put(std::string_view(prepared.error().detail));
        sendFrame(kServerSocket, FrameType::Failure, content.bytes());
        return 1;
    }
    WireWriter hello;
    hello.put(std::string_view(LIGHTCOOK_VERSION));
    sendFrame(kServerSocket, FrameType::Hello, hello.bytes());
    std::set<pid_t> readers, ending;
    while (auto request = receiveFrame(kServerSocket)) {
        if (request->type == FrameType::Start) {
            const pid_t reader = forkReader(program, *request);
            if (reader != 0) readers.insert(reader);
            answerProgram(reader != 0 ? FrameType::Answer : FrameType::Failure, reader != 0 ? reader : errno);
        } else {
            WireReader arguments(std::move(request->content));
            const auto reader = arguments.get<std::int32_t>();
            int status = 0;
            const bool isOurs = readers.erase(reader) > 0;  // not one of a server before this one
            if (isOurs) ::kill(reader, SIGKILL);
            if (isOurs && request->type == FrameType::Release) ending.insert(reader);
            if (request->type == FrameType::GetStatus) {
                const bool hasEnded = isOurs && retried([&] { return ::waitpid(reader, &status, 0); }) == reader;
                answerProgram(hasEnded ? FrameType::Answer : FrameType::Failure, status);
            }
        }
        reap(ending);
    }
    return 0;
}

}  // namespace lightcook::formats
