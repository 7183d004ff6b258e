#include "formats/reader/reader_process.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstring>
#include <ctime>
#include <mutex>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include "formats/file/file_kind.h"
#include "formats/file/one_line.h"
#include "formats/foreign_files.h"
#include "formats/memory.h"
#include "formats/reader/walls.h"
#include "formats/spawn.h"
#include "formats/system_calls.h"

namespace lightcook::formats {
namespace {

namespace fs = std::filesystem;

std::optional<ReaderOptions>& options() {
    static std::optional<ReaderOptions> only;
    return only;
}

/// Walls that all readers had; kNoReader before the first.
constexpr Walls kNoReader = ~Walls{0};
std::atomic<Walls> commonWalls{kNoReader};

tl::unexpected<Error> systemFault(std::string_view subject, std::string_view step, int errorNumber) {
    return failure(ErrorCode::Internal, std::string(subject),
                   fmt::format("found \"{}\" while {}, expected a process that reads files", std::strerror(errorNumber), step));
}

struct SocketPair {
    Descriptor ours, theirs;
};
std::optional<SocketPair> makeSockets() {
    std::array<int, 2> ends{};
    if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) return std::nullopt;
    return SocketPair{Descriptor(ends[0]), Descriptor(ends[1])};
}

/// A server of readers: a child process that forks them. Shared by all threads.
class ReaderServer {
public:
    explicit ReaderServer(ReaderFamily family) : family_(family) {}

    /// Ends the server, if there is one.
    void stop() {
        const std::lock_guard lock(mutex_);
        drop();
    }
    /// Returns the process of a new reader.
    Result<pid_t> start(ForeignKind kind, std::uint64_t memory, const fs::path& path, int socket, int file) {
        const std::lock_guard lock(mutex_);
        LC_CHECK(launch());
        WireWriter request;
        request.put(kind);
        request.put(memory);
        request.put(std::string_view(path.native()));
        const std::array<int, 2> descriptors = {socket, file};
        auto answer = exchange(FrameType::Start, request, descriptors);
        if (!answer) return systemFault(options()->program.string(), "starting a reader", ECHILD);
        WireReader content(std::move(answer->content));
        const auto number = content.get<std::int32_t>();
        if (answer->type != FrameType::Answer) return systemFault(options()->program.string(), "starting a reader", number);
        return number;
    }
    void release(pid_t reader) {
        const std::lock_guard lock(mutex_);
        WireWriter request;
        request.put(static_cast<std::int32_t>(reader));
        if (socket_.isOpen()) sendFrame(socket_.number(), FrameType::Release, request.bytes());
    }
    /// Ends a reader. Returns its status as waitpid(2) has it; that of SIGKILL if the server has ended itself, which takes all along.
    int statusOf(pid_t reader) {
        const std::lock_guard lock(mutex_);
        WireWriter request;
        request.put(static_cast<std::int32_t>(reader));
        auto answer = exchange(FrameType::GetStatus, request, {});
        if (!answer || answer->type != FrameType::Answer) return SIGKILL;
        return WireReader(std::move(answer->content)).get<std::int32_t>();
    }

private:
    /// A server does nothing that takes long: whoever does not answer has gone wrong.
    std::optional<Frame> receive() {
        constexpr int kTickMs = 1000, kMostTicks = 120;
        int ticks = 0;
        return receiveFrame(socket_.number(), kTickMs, [&] { return ++ticks < kMostTicks; });
    }
    std::optional<Frame> exchange(FrameType type, const WireWriter& request, std::span<const int> descriptors) {
        if (!socket_.isOpen()) return std::nullopt;
        std::optional<Frame> answer;
        if (sendFrame(socket_.number(), type, request.bytes(), descriptors)) answer = receive();
        if (!answer) drop();  // the next file starts another server
        return answer;
    }

    /// Ends the server, and its readers with it.
    void drop() {
        socket_ = Descriptor();
        if (process_ == 0) return;
        ::kill(process_, SIGKILL);
        retried([this] { return ::waitpid(process_, nullptr, 0); });
        process_ = 0;
    }

    Result<void> launch() {
        if (socket_.isOpen()) return {};
        const fs::path& program = options()->program;
        auto sockets = makeSockets();
        if (!sockets) return systemFault("socket", "making a pair", errno);
        SpawnFiles files;
        files.give(sockets->theirs.number(), kServerSocket);                   // first: it may have the number of a standard stream
        for (const int stream : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})  // libraries print warnings
            if (stream != STDERR_FILENO || !areReadersSanitized()) files.giveNothing(stream);
        int fault = 0;
        std::tie(process_, fault) =
            spawn(program.string(), {program.string(), std::string(kFamilyNames.at(static_cast<std::size_t>(family_)))}, files);
        if (fault != 0)
            return failure(
                ErrorCode::Internal, program,
                fmt::format("found \"{}\", expected the program that reads images beside lightcook: install it too, or trust all "
                            "input files and give --no-sandbox",
                            std::strerror(fault)));
        sockets->theirs = Descriptor();
        std::swap(socket_, sockets->ours);
        auto hello = receive();
        if (hello && hello->type == FrameType::Hello) {
            const std::string version = WireReader(std::move(hello->content)).text();
            if (version == LIGHTCOOK_VERSION) return {};
            drop();
            return failure(ErrorCode::Internal, program,
                           fmt::format("found lightcook-read {} instead of {}, expected one version of all programs: install them again",
                                       oneLine(version), LIGHTCOOK_VERSION));
        }
        drop();
        if (hello && hello->type == FrameType::Failure) {
            WireReader why(std::move(hello->content));
            const std::string subject = why.text(), detail = why.text();
            return failure(ErrorCode::Internal, subject, detail);
        }
        return failure(ErrorCode::Internal, program, "found a program that says nothing, expected lightcook-read: install it again");
    }

    const ReaderFamily family_;
    std::mutex mutex_;
    Descriptor socket_;
    pid_t process_ = 0;
};

/// Never destroyed: readers may be released while static objects are.
ReaderServer& serverOf(ForeignKind kind) {
    static auto* const files = new ReaderServer(ReaderFamily::Files);
    static auto* const images = new ReaderServer(ReaderFamily::Images);
    return familyOf(kind) == ReaderFamily::Files ? *files : *images;
}

/// The part of a file that a reader has filled: memory that both processes map. Its size is sealed, or a reader could cut it off under
/// our eyes.
class SharedWindow {
public:
    SharedWindow() = default;
    SharedWindow(const SharedWindow&) = delete;
    SharedWindow& operator=(const SharedWindow&) = delete;
    ~SharedWindow() { unmap(); }

    std::size_t size() const { return bytes_; }
    std::span<const std::byte> first(std::size_t count) const { return {static_cast<const std::byte*>(place_), count}; }
    /// Returns the descriptor of a new window; one that is not open, with the cause in errno.
    Descriptor make(std::size_t bytes) {
        unmap();
        Descriptor file(::memfd_create("lightcook-window", MFD_CLOEXEC | MFD_ALLOW_SEALING));
        if (!file.isOpen() || retried([&] { return ::ftruncate(file.number(), static_cast<off_t>(bytes)); }) != 0) return Descriptor();
        if (::fcntl(file.number(), F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_SEAL) != 0) return Descriptor();
        void* const place = ::mmap(nullptr, bytes, PROT_READ, MAP_SHARED, file.number(), 0);
        if (place == MAP_FAILED) return Descriptor();
        place_ = place;
        bytes_ = bytes;
        return file;
    }

private:
    void unmap() {
        if (bytes_ > 0) ::munmap(place_, bytes_);
        bytes_ = 0;
    }
    void* place_ = nullptr;
    std::size_t bytes_ = 0;
};

/// Tells whether a reader is still at work, by the CPU time that it takes.
class Watch {
public:
    Watch(pid_t reader, double seconds) : seconds_(seconds) {
        isClocked_ = ::clock_getcpuclockid(reader, &clock_) == 0;
        restart();
    }
    int tickMs() const { return std::clamp(static_cast<int>(seconds_ * 1000 / 8), 1, 1000); }
    /// Called after each tick without a message. Counts ticks and not the time of day: this process may have been stopped. Returns
    /// false if the reader is to end.
    bool tick() {
        ++ticks_;
        ++allTicks_;
        const double waited = ticks_ * tickMs() / 1000.0, used = cpuSeconds() - cpuAtStart_;
        constexpr double kIdleShare = 0.05, kMostSeconds = 4 * 3600;
        const bool isIdle = waited >= 2 * seconds_ && used < kIdleShare * waited;
        isOver_ = used >= seconds_ || isIdle || waited >= 30 * seconds_ || allTicks_ * tickMs() / 1000.0 >= kMostSeconds;
        return !isOver_;
    }
    /// Called when the reader tells of progress. Returns false if it told of too much.
    bool restart() {
        constexpr int kMostProgress = 30000;  // at most twice a second
        ticks_ = 0;
        cpuAtStart_ = cpuSeconds();
        isOver_ = isOver_ || ++restarts_ > kMostProgress;
        return !isOver_;
    }
    bool isOver() const { return isOver_; }

private:
    double cpuSeconds() const {
        timespec time{};
        if (!isClocked_ || ::clock_gettime(clock_, &time) != 0) return cpuAtStart_;
        return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
    }
    double seconds_;
    clockid_t clock_{};
    bool isClocked_ = false, isOver_ = false;
    double cpuAtStart_ = 0;
    int ticks_ = 0, allTicks_ = 0, restarts_ = 0;
};

constexpr const char* kAdvice =
    "expected one that it can read: the file is damaged or made to harm; export it anew. A debugger sees the decoder with --no-sandbox";

/// Returns the signal's name: "SIGSEGV".
std::string nameOfSignal(int number) {
    const char* const name = ::sigabbrev_np(number);
    return name != nullptr ? fmt::format("SIG{}", name) : fmt::format("signal {}", number);
}

}  // namespace

void readInChildProcesses(ReaderOptions chosen) {
    options() = std::move(chosen);
    for (const ForeignKind kind : {ForeignKind::Exr, ForeignKind::Image}) serverOf(kind).stop();
}

std::vector<std::string> wallsOfReaders() {
    if (!areReadersChildren()) return {"none"};
    const Walls walls = commonWalls;
    if (walls == kNoReader) return {};
    std::vector<std::string> names = namesOfWalls(walls);
    names.insert(names.begin(), "process");
    return names;
}

bool areReadersChildren() {
    return options().has_value();
}

Result<Descriptor> openForeignFile(const fs::path& file, const char* expected) {
    const auto fault = [&](std::string_view found) {
        return failure(ErrorCode::FileUnreadable, file, fmt::format("found {}, expected {}", found, expected));
    };
    if (const auto found = whyNoFile(file)) return fault(*found);
    Descriptor descriptor(retried([&] { return ::open(file.c_str(), O_RDONLY | O_CLOEXEC); }));
    if (!descriptor.isOpen()) return fault(quotedLine(std::strerror(errno)));
    return descriptor;
}

Descriptor makeMemoryFile(std::span<const std::byte> bytes) {
    Descriptor file(::memfd_create("lightcook-file", MFD_CLOEXEC));
    const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return file.isOpen() && writeWhole(file.number(), text) ? std::move(file) : Descriptor();
}

struct ReaderProcess::State {
    ForeignKind kind;
    fs::path path;
    std::uint64_t memory = 0;
    pid_t process = 0;  ///< 0: it has ended, and the server knows
    Descriptor socket;
    SharedWindow window;

    ~State() {
        if (process != 0) serverOf(kind).release(process);
    }
    /// Ends the reader after it did not answer. Returns the error of the file.
    Error end(const Watch& watch) {
        char byte = 0;
        const bool hasEnded = ::recv(socket.number(), &byte, 1, MSG_PEEK | MSG_DONTWAIT) <= 0 && errno != EAGAIN;
        const int status = serverOf(kind).statusOf(std::exchange(process, 0));
        const auto fault = [this](std::string what) {
            return Error(ErrorCode::FileUnreadable, path, fmt::format("found {}, {}", what, kAdvice));
        };
        if (watch.isOver())
            return fault(fmt::format("content on which its reader worked for {:.3g} s without progress", options()->seconds));
        if (!hasEnded) return senseless();
        if (WIFSIGNALED(status) && WTERMSIG(status) == SIGXCPU) return fault("content on which its reader worked for hours");
        if (WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL)
            return fault("content whose reader was ended from outside (SIGKILL), as the system does where memory runs out");
        if (WIFSIGNALED(status)) return fault(fmt::format("content on which its reader crashed ({})", nameOfSignal(WTERMSIG(status))));
        return fault("content on which its reader ended without an answer");
    }
    Error senseless() const {
        return {ErrorCode::FileUnreadable, path, fmt::format("found content on which its reader went wrong, {}", kAdvice)};
    }
    Error outOfMemory() {
        serverOf(kind).release(std::exchange(process, 0));
        return {ErrorCode::FileUnreadable, path,
                fmt::format("found content for which its reader takes more than its limit of {} MiB of memory, {}", memory >> 20, kAdvice)};
    }
    Result<std::vector<std::byte>> ask(FrameType type, const WireWriter& arguments) {
        if (process == 0) return failure(ErrorCode::FileUnreadable, path, "found a file whose reader has ended before");
        Watch watch(process, options()->seconds);
        if (!sendFrame(socket.number(), type, arguments.bytes())) return tl::make_unexpected(end(watch));
        for (;;) {
            auto frame = receiveFrame(socket.number(), watch.tickMs(), [&] { return watch.tick(); });
            if (!frame) return tl::make_unexpected(end(watch));
            switch (frame->type) {
                case FrameType::Answer:
                    return std::move(frame->content);
                case FrameType::Failure:
                    return tl::make_unexpected(errorOf(std::move(frame->content)));
                case FrameType::OutOfMemory:
                    return tl::make_unexpected(outOfMemory());
                case FrameType::Progress:
                    if (!watch.restart()) return tl::make_unexpected(end(watch));
                    continue;
                default:
                    return tl::make_unexpected(end(watch));
            }
        }
    }
    /// Returns the error that a reader has sent. It is about its file, whatever it says.
    Error errorOf(std::vector<std::byte> bytes) const {
        constexpr std::array kCodes = {ErrorCode::FileUnreadable, ErrorCode::FormatUnsupported, ErrorCode::UnknownBake,
                                       ErrorCode::WrongShape,     ErrorCode::ValueNotFinite,    ErrorCode::ValueOutOfRange};
        WireReader content(std::move(bytes));
        const auto code = content.get<ErrorCode>();
        constexpr std::size_t kLongestDetail = 4096;
        const std::string subject = content.text(), detail = content.text().substr(0, kLongestDetail);
        const bool isKnown = std::ranges::find(kCodes, code) != kCodes.end();
        Error error(isKnown ? code : ErrorCode::FileUnreadable, path, detail);
        if (subject.starts_with(path.string())) error.subject = subject;
        return error;
    }
};

ReaderProcess::ReaderProcess(std::unique_ptr<State> state) : state_(std::move(state)) {}
ReaderProcess::ReaderProcess(ReaderProcess&&) noexcept = default;
ReaderProcess& ReaderProcess::operator=(ReaderProcess&&) noexcept = default;
ReaderProcess::~ReaderProcess() = default;

Result<ReaderProcess> ReaderProcess::start(ForeignKind kind, int file, const fs::path& path) {
    auto sockets = makeSockets();
    if (!sockets) return systemFault(path.string(), "opening it", errno);
    std::unique_ptr<State> state(new State{kind, path, options()->memoryBytes, 0, std::move(sockets->ours), {}});
    if (state->memory == 0) state->memory = availableMemory();
    LC_TRY(process, serverOf(kind).start(kind, state->memory, path, sockets->theirs.number(), file));
    state->process = *process;
    return ReaderProcess(std::move(state));
}

Result<std::unique_ptr<WireReader>> ReaderProcess::open(const WireWriter& arguments) {
    LC_TRY(answer, state_->ask(FrameType::Open, arguments));
    auto description = std::make_unique<WireReader>(std::move(*answer));
    commonWalls &= description->get<Walls>() & kAllWalls;
    return description;
}

Result<std::span<const std::byte>> ReaderProcess::read(const WireWriter& arguments, std::size_t bytes) {
    State& state = *state_;
    if (state.window.size() < bytes) {
        const Descriptor window = state.window.make(bytes);
        WireWriter size;
        size.put(static_cast<std::uint64_t>(bytes));
        const std::array<int, 1> descriptors = {window.number()};
        if (!window.isOpen()) return systemFault(state.path.string(), "sharing memory with its reader", errno);
        sendFrame(state.socket.number(), FrameType::Window, size.bytes(), descriptors);  // a reader that has ended does not answer below
    }
    LC_TRY(answer, state.ask(FrameType::Read, arguments));
    return state.window.first(bytes);
}

tl::unexpected<Error> ReaderProcess::senseless() const {
    return tl::make_unexpected(state_->senseless());
}

}  // namespace lightcook::formats
