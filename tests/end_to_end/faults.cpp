// A shared object for LD_PRELOAD that lets the n-th call of a kind of system function fail: once, or from n on. It counts the calls in a
// file that the test maps too, so that n runs from 1 until a run has none left. faults_test.cpp uses it.
//
// LIGHTCOOK_FAULT         "KIND:N:HOW". HOW is a number of errno, or "short": one byte is read or written. A "+" after it lets all later
//                         calls of the kind fail too. Empty: none fails
// LIGHTCOOK_FAULT_FILE    a file of kFileBytes, as faults.h has it
// LIGHTCOOK_FAULT_STACKS  with this number of return addresses, it is noted which allocations were the first of their call stack: of all
//                         that fail at one place, one is enough
//
// Calls of the dynamic loader, and of initializers of libraries that run before the one here, do not count.
#include <dirent.h>
#include <dlfcn.h>
#include <execinfo.h>
#include <fcntl.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/sendfile.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include "tests/end_to_end/faults.h"

extern "C" {
void* __libc_malloc(std::size_t);                 // NOLINT
void* __libc_calloc(std::size_t, std::size_t);    // NOLINT
void* __libc_realloc(void*, std::size_t);         // NOLINT
void* __libc_memalign(std::size_t, std::size_t);  // NOLINT
}

namespace {

using namespace lightcook::faults;

FaultFile ownCounters;  // until the file is mapped
FaultFile* counters = &ownCounters;
int faultyKind = -1, faultErrno = 0;
std::uint64_t faultyCall = 0;
bool isLasting = false, isShort = false;
bool isCounting = false;

constexpr std::size_t kPlaces = std::size_t{1} << 20;
std::uint64_t stacksSeen[kPlaces];  // a hash table of hashes
int stackDepth = 0;
thread_local bool isInside = false;

/// Notes an allocation whose call stack none had before.
void noteStack(std::uint64_t call) {
    if (isInside) return;
    isInside = true;
    void* frames[64];
    const int count = backtrace(frames, stackDepth + 2);
    std::uint64_t hash = 1;
    for (int i = 2; i < count; ++i) hash = (hash ^ reinterpret_cast<std::uint64_t>(frames[i])) * 0x9e3779b97f4a7c15u, hash ^= hash >> 29;
    std::size_t place = hash % kPlaces;
    while (stacksSeen[place] != 0 && stacksSeen[place] != hash) place = (place + 1) % kPlaces;
    if (stacksSeen[place] == 0) {
        stacksSeen[place] = hash;
        if (counters->stackCount < std::size(counters->firstOfStack)) counters->firstOfStack[counters->stackCount++] = call;
    }
    isInside = false;
}

/// Counts a call. Returns true if it is to fail, with errno set.
bool isFaulty(Kind kind) {
    if (!isCounting) return false;
    if (isInside) return false;
    const std::uint64_t call = ++counters->calls[kind];
    if (kind == Alloc && stackDepth > 0) noteStack(call);
    if (kind != faultyKind || (isLasting ? call < faultyCall : call != faultyCall)) return false;
    ++counters->failed;
    errno = faultErrno;
    return true;
}

/// Makes a call that moves up to `count` bytes, unless it is to fail. What is said on standard error is what the test reads.
template <class Call>
ssize_t transfer(Kind kind, int file, std::size_t& count, Call call) {
    if (file != STDERR_FILENO && isFaulty(kind)) {
        if (!isShort) return -1;
        count = std::min<std::size_t>(count, 1);
    }
    return call();
}

template <class Function>
Function* next(const char* name) {
    return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}

__attribute__((constructor)) void begin() {
    if (const char* file = std::getenv("LIGHTCOOK_FAULT_FILE")) {
        const long descriptor = syscall(SYS_openat, AT_FDCWD, file, O_RDWR, 0);
        const long place = syscall(SYS_mmap, nullptr, sizeof(FaultFile), PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
        if (descriptor < 0 || place < 0) abort();
        syscall(SYS_close, descriptor);
        counters = reinterpret_cast<FaultFile*>(place);  // NOLINT(performance-no-int-to-ptr): of a system call
    }
    const char* fault = std::getenv("LIGHTCOOK_FAULT");
    if (fault != nullptr && *fault != '\0') {
        const std::string_view text = fault;
        for (int kind = 0; kind < kKinds; ++kind)
            if (text.substr(0, text.find(':')) == kKindNames[kind]) faultyKind = kind;
        char* rest = nullptr;
        faultyCall = std::strtoull(fault + text.find(':') + 1, &rest, 10);
        isLasting = text.back() == '+';
        isShort = std::string_view(rest).substr(0, 6) == ":short";
        faultErrno = isShort ? 0 : std::atoi(rest + 1);
        if (faultyKind < 0) abort();
    }
    if (const char* depth = std::getenv("LIGHTCOOK_FAULT_STACKS")) {
        stackDepth = std::atoi(depth);
        void* frame[4];
        backtrace(frame, 4);  // loads the unwinder
    }
    unsetenv("LD_PRELOAD");  // programs that this one starts
    isCounting = true;
}

}  // namespace

extern "C" {

void* malloc(std::size_t bytes) {
    return isFaulty(Alloc) ? nullptr : __libc_malloc(bytes);
}
void* calloc(std::size_t count, std::size_t bytes) {
    return isFaulty(Alloc) ? nullptr : __libc_calloc(count, bytes);
}
void* realloc(void* old, std::size_t bytes) {
    return isFaulty(Alloc) ? nullptr : __libc_realloc(old, bytes);
}
void* aligned_alloc(std::size_t alignment, std::size_t bytes) {
    return isFaulty(Alloc) ? nullptr : __libc_memalign(alignment, bytes);
}
void* memalign(std::size_t alignment, std::size_t bytes) {
    return isFaulty(Alloc) ? nullptr : __libc_memalign(alignment, bytes);
}
int posix_memalign(void** out, std::size_t alignment, std::size_t bytes) {
    if (isFaulty(Alloc)) return ENOMEM;
    *out = __libc_memalign(alignment, bytes);
    return *out == nullptr ? ENOMEM : 0;
}

int open(const char* path, int flags, ...) {
    va_list arguments;
    va_start(arguments, flags);
    const int mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(arguments, int) : 0;
    va_end(arguments);
    return isFaulty(Open) ? -1 : static_cast<int>(syscall(SYS_openat, AT_FDCWD, path, flags, mode));
}
int open64(const char* path, int flags, ...) __attribute__((alias("open")));
int openat(int folder, const char* path, int flags, ...) {
    va_list arguments;
    va_start(arguments, flags);
    const int mode = (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(arguments, int) : 0;
    va_end(arguments);
    return isFaulty(Open) ? -1 : static_cast<int>(syscall(SYS_openat, folder, path, flags, mode));
}
int openat64(int folder, const char* path, int flags, ...) __attribute__((alias("openat")));
FILE* fopen64(const char* path, const char* mode) {
    static const auto real = next<FILE*(const char*, const char*)>("fopen64");
    return isFaulty(Open) ? nullptr : real(path, mode);
}
FILE* fopen(const char* path, const char* mode) __attribute__((alias("fopen64")));
DIR* opendir(const char* path) {
    static const auto real = next<DIR*(const char*)>("opendir");
    return isFaulty(Open) ? nullptr : real(path);
}

ssize_t read(int file, void* out, std::size_t count) {
    return transfer(Read, file, count, [&] { return syscall(SYS_read, file, out, count); });
}
ssize_t pread(int file, void* out, std::size_t count, off_t at) {
    return transfer(Read, file, count, [&] { return syscall(SYS_pread64, file, out, count, at); });
}
ssize_t pread64(int file, void* out, std::size_t count, off64_t at) __attribute__((alias("pread")));
ssize_t write(int file, const void* from, std::size_t count) {
    return transfer(Write, file, count, [&] { return syscall(SYS_write, file, from, count); });
}
ssize_t pwrite(int file, const void* from, std::size_t count, off_t at) {
    return transfer(Write, file, count, [&] { return syscall(SYS_pwrite64, file, from, count, at); });
}
ssize_t pwrite64(int file, const void* from, std::size_t count, off64_t at) __attribute__((alias("pwrite")));
ssize_t sendfile(int out, int in, off_t* at, std::size_t count) {
    return transfer(Write, out, count, [&] { return syscall(SYS_sendfile, out, in, at, count); });
}
ssize_t sendfile64(int out, int in, off64_t* at, std::size_t count) __attribute__((alias("sendfile")));
ssize_t writev(int file, const iovec* pieces, int count) {
    if (count == 0 || !isFaulty(Write)) return syscall(SYS_writev, file, pieces, count);
    return isShort ? syscall(SYS_write, file, pieces->iov_base, std::min<std::size_t>(pieces->iov_len, 1)) : -1;
}

int fsync(int file) {
    return isFaulty(Sync) ? -1 : static_cast<int>(syscall(SYS_fsync, file));
}
int ftruncate(int file, off_t bytes) {
    return isFaulty(Sync) ? -1 : static_cast<int>(syscall(SYS_ftruncate, file, bytes));
}
int ftruncate64(int file, off64_t bytes) __attribute__((alias("ftruncate")));
int rename(const char* from, const char* to) {
    return isFaulty(Rename) ? -1 : static_cast<int>(syscall(SYS_rename, from, to));
}
int mkdir(const char* path, mode_t mode) {
    return isFaulty(Rename) ? -1 : static_cast<int>(syscall(SYS_mkdir, path, mode));
}
int symlink(const char* from, const char* to) {
    return isFaulty(Rename) ? -1 : static_cast<int>(syscall(SYS_symlink, from, to));
}
void* mmap(void* place, std::size_t bytes, int protection, int flags, int file, off_t at) {
    // NOLINTNEXTLINE(performance-no-int-to-ptr): of a system call
    return isFaulty(Map) ? MAP_FAILED : reinterpret_cast<void*>(syscall(SYS_mmap, place, bytes, protection, flags, file, at));
}
void* mmap64(void* place, std::size_t bytes, int protection, int flags, int file, off64_t at) __attribute__((alias("mmap")));
int pthread_create(pthread_t* thread, const pthread_attr_t* attributes, void* (*function)(void*), void* argument) {
    static const auto real = next<int(pthread_t*, const pthread_attr_t*, void* (*)(void*), void*)>("pthread_create");
    return isFaulty(Thread) ? EAGAIN : real(thread, attributes, function, argument);
}

}  // extern "C"
