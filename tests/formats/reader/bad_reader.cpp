// A lightcook-read whose decoders do what no decoder should. The file says what, in a word after the first eight bytes of an OpenEXR file;
// every other file is decoded.
//
// LIGHTCOOK_BAD_READER   "version": it says that it is another version
#include <fcntl.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/ptrace.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>
#include <vector>

#include "formats/reader/decoders.h"

namespace lightcook::formats {
namespace {

long call(long number, long a = 0, long b = 0, long c = 0, long d = 0, long e = 0) {
    return ::syscall(number, a, b, c, d, e);
}
template <class T>
long of(T* pointer) {
    return reinterpret_cast<long>(pointer);
}

/// Returns the names of the calls that a reader can make and should not, and of what it needs and cannot.
std::string gapsInWalls() {
    std::string gaps;
    const auto refuse = [&gaps](const char* name, long result) {
        if (result >= 0 || (errno != EPERM && errno != EACCES && errno != ENOSYS)) gaps += std::string(" ") + name;
    };
    static const char kFile[] = "/etc/passwd", kNew[] = "/tmp/lightcook-escape", kShell[] = "/bin/true";
    const char* const arguments[] = {kShell, nullptr};
    char byte = 0;
    std::uint64_t process[16] = {};  // clone_args, and place for what others write
    process[4] = SIGCHLD;
    flock lock{};
    refuse("openat", call(SYS_openat, AT_FDCWD, of(kFile), O_RDONLY));
    refuse("openat of the file again", call(SYS_openat, AT_FDCWD, of("/proc/self/fd/5"), O_RDONLY));
    refuse("creat", call(SYS_openat, AT_FDCWD, of(kNew), O_WRONLY | O_CREAT, 0600));
    refuse("openat2", call(SYS_openat2, AT_FDCWD, of(kFile), of(process), 24));
    refuse("newfstatat", call(SYS_newfstatat, AT_FDCWD, of(kFile), of(process), 0));
    refuse("readlinkat", call(SYS_readlinkat, AT_FDCWD, of("/proc/self/exe"), of(&byte), 1));
    refuse("unlinkat", call(SYS_unlinkat, AT_FDCWD, of(kNew), 0));
    refuse("mkdirat", call(SYS_mkdirat, AT_FDCWD, of(kNew), 0700));
    refuse("chdir", call(SYS_chdir, of("/")));
    refuse("memfd_create", call(SYS_memfd_create, of("x"), 0));
    refuse("socket", call(SYS_socket, AF_INET, SOCK_STREAM, 0));
    refuse("socket of unix", call(SYS_socket, AF_UNIX, SOCK_STREAM, 0));
    refuse("socketpair", call(SYS_socketpair, AF_UNIX, SOCK_STREAM, 0, of(process)));
    refuse("connect", call(SYS_connect, kReaderSocket, of(process), 16));
    refuse("execve", call(SYS_execve, of(kShell), of(arguments), of(arguments + 1)));
    refuse("clone", call(SYS_clone, SIGCHLD));
    refuse("clone3", call(SYS_clone3, of(process), 64));
    refuse("unshare", call(SYS_unshare, CLONE_NEWUSER));
    refuse("kill", call(SYS_kill, ::getppid(), 0));
    refuse("tgkill", call(SYS_tgkill, ::getppid(), ::getppid(), 0));
    refuse("ptrace", call(SYS_ptrace, PTRACE_ATTACH, ::getppid()));
    refuse("process_vm_readv", call(SYS_process_vm_readv, ::getppid()));
    refuse("pidfd_open", call(SYS_pidfd_open, ::getppid(), 0));
    refuse("prlimit64 of another", call(SYS_prlimit64, ::getppid(), 0, 0, of(process)));
    refuse("fcntl F_SETOWN", call(SYS_fcntl, kReaderSocket, F_SETOWN, ::getppid()));
    refuse("fcntl F_SETLK", call(SYS_fcntl, kReaderFile, F_SETLK, of(&lock)));
    refuse("io_uring_setup", call(SYS_io_uring_setup, 1, of(process)));
    refuse("bpf", call(SYS_bpf, 0, of(process), 1));
    refuse("mmap of code", call(SYS_mmap, 0, 4096, PROT_READ | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1));
    void* const page = ::mmap(nullptr, 4096, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    refuse("mprotect to code", call(SYS_mprotect, of(page), 4096, PROT_READ | PROT_EXEC));
    if (page == MAP_FAILED || ::munmap(page, 4096) != 0) gaps += " (no mmap)";
    // The size of the window is sealed, and it is not one of these.
    for (int number = 0; number < 64; ++number)
        if (number > STDERR_FILENO && number != kReaderSocket && number != kReaderFile && ::lseek(number, 0, SEEK_CUR) >= 0)
            gaps += " descriptor " + std::to_string(number);
    if (::read(kReaderFile, &byte, 1) != 1) gaps += " (no read of the file)";
    return gaps;
}

std::string wordOf(const ForeignInput& input) {
    char bytes[64] = {};
    (void)!::pread(input.descriptor, bytes, sizeof bytes - 1, 8);
    return bytes;
}

/// Decodes OpenEXR files, unless a word says otherwise.
class BadDecoder : public ForeignDecoder {
public:
    explicit BadDecoder(const ForeignInput& input) : input_(input), decoder_(decodeExrBehindWall(input)) {}
    Result<void> open(WireReader& arguments, WireWriter& description) override {
        const std::string word = wordOf(input_);
        if (word == "crash") ::raise(SIGSEGV);
        if (word == "abort") std::abort();
        if (word == "exit") ::_exit(0);
        if (word == "throw") throw std::string("what no one expects");
        while (word == "hang") asm volatile("");
        while (word == "sleep") ::usleep(10000);
        while (word == "eat") std::ranges::fill(*new std::array<char, 1 << 20>, 'x');
        if (word == "claim") eaten_.resize(std::size_t{1} << 45);
        if (word == "nonsense") description.put(std::string_view("no image"));
        if (word == "huge") sendFrame(kReaderSocket, FrameType::Answer, std::vector<std::byte>(kLongestFrame + 1));
        if (word == "walls") return failure(ErrorCode::WrongShape, input_.path, "gaps:" + gapsInWalls());
        if (word == "work")
            for (int i = 0; i < 4; ++i) {
                ::usleep(600000);
                reportProgress();
            }
        if (word == "nonsense" || word == "huge") return {};
        if (word == "work") return failure(ErrorCode::WrongShape, input_.path, "worked");
        return decoder_->open(arguments, description);
    }
    Result<void> read(WireReader& arguments, std::span<std::byte> out) override { return decoder_->read(arguments, out); }

private:
    ForeignInput input_;
    std::unique_ptr<ForeignDecoder> decoder_;
    std::vector<char> eaten_;
};

constexpr ReaderProgram kProgram = {
    {[](const ForeignInput& input) -> std::unique_ptr<ForeignDecoder> { return std::make_unique<BadDecoder>(input); },
     decodeImageBehindWall, decodeDracoBehindWall, measureDracoBehindWall},
    [](ReaderFamily /*family*/) { return Result<void>(); },
    [](const ForeignInput& /*input*/) {}};

}  // namespace
}  // namespace lightcook::formats

int main() {
    using namespace lightcook::formats;
    const char* const how = std::getenv("LIGHTCOOK_BAD_READER");
    if (how != nullptr && std::string_view(how) == "version") {
        WireWriter hello;
        hello.put(std::string_view("0.0.1"));
        sendFrame(kServerSocket, FrameType::Hello, hello.bytes());
        return 0;
    }
    return serveReaders(ReaderFamily::Files, kProgram);
}
