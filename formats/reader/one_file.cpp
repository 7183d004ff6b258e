#include "formats/reader/one_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <string>
#include <string_view>

namespace {

/// Each reader of a format that looks at an image opens it once or twice.
constexpr std::size_t kOpenings = 96;

struct OneFile {
    std::string name;
    std::array<int, kOpenings> descriptors{};  ///< each with a place of its own in the file
    std::atomic<std::size_t> given{0};
    int kept = -1;  ///< for stat()
};
OneFile& oneFile() {
    static auto* const only = new OneFile;  // libraries open files until the process ends
    return *only;
}
bool isAlone = false;  ///< no other file may be opened

bool isTheFile(const char* path) {
    return oneFile().name == path;
}

int openHere(int folder, const char* path, int flags, mode_t mode) {
    if (!isAlone) return static_cast<int>(::syscall(SYS_openat, folder, path, flags, mode));
    if (!isTheFile(path) || (flags & (O_ACCMODE | O_CREAT | O_TRUNC)) != O_RDONLY) {
        errno = isTheFile(path) ? EROFS : ENOENT;
        return -1;
    }
    const std::size_t next = oneFile().given++;
    if (next < kOpenings) return oneFile().descriptors.at(next);
    errno = EMFILE;
    return -1;
}

/// The descriptor to ask in place of a path; -1 with the cause in errno.
int keptFor(const char* path) {
    if (isTheFile(path)) return oneFile().kept;
    errno = ENOENT;
    return -1;
}

int statHere(int folder, const char* path, struct stat* out, int flags) {
    if (!isAlone || ((flags & AT_EMPTY_PATH) != 0 && *path == '\0'))
        return static_cast<int>(::syscall(SYS_newfstatat, folder, path, out, flags));
    const int kept = keptFor(path);
    return kept < 0 ? -1 : ::fstat(kept, out);
}

mode_t modeOf(int flags, std::va_list arguments) {
    return (flags & (O_CREAT | O_TMPFILE)) != 0 ? va_arg(arguments, mode_t) : 0;
}

std::FILE* fopenHere(const char* path, const char* mode) {
    const std::string_view how = mode;
    const bool updates = how.find('+') != std::string_view::npos;
    int flags = updates ? O_RDWR : how.starts_with('r') ? O_RDONLY : O_WRONLY;
    if (how.starts_with('w')) flags |= O_CREAT | O_TRUNC;
    if (how.starts_with('a')) flags |= O_CREAT | O_APPEND;
    if (how.find('e') != std::string_view::npos) flags |= O_CLOEXEC;
    const int descriptor = openHere(AT_FDCWD, path, flags, 0666);
    return descriptor < 0 ? nullptr : ::fdopen(descriptor, mode);
}

}  // namespace

namespace lightcook::formats {

void allowOneFile(const std::filesystem::path& name, int descriptor) {
    OneFile& file = oneFile();
    file.name = name.string();
    file.kept = descriptor;
    const std::string again = "/proc/self/fd/" + std::to_string(descriptor);
    for (int& each : file.descriptors) each = ::open(again.c_str(), O_RDONLY | O_CLOEXEC);
    isAlone = true;
}

}  // namespace lightcook::formats

extern "C" {

int open(const char* path, int flags, ...) {
    std::va_list arguments;
    va_start(arguments, flags);
    const int descriptor = openHere(AT_FDCWD, path, flags, modeOf(flags, arguments));
    va_end(arguments);
    return descriptor;
}
int openat(int folder, const char* path, int flags, ...) {
    std::va_list arguments;
    va_start(arguments, flags);
    const int descriptor = openHere(folder, path, flags, modeOf(flags, arguments));
    va_end(arguments);
    return descriptor;
}
int open64(const char* path, int flags, ...) __attribute__((alias("open")));
int openat64(int folder, const char* path, int flags, ...) __attribute__((alias("openat")));
std::FILE* fopen(const char* path, const char* mode) {
    return fopenHere(path, mode);
}
std::FILE* fopen64(const char* path, const char* mode) {
    return fopenHere(path, mode);
}
int stat(const char* path, struct stat* out) noexcept {
    return statHere(AT_FDCWD, path, out, 0);
}
int lstat(const char* path, struct stat* out) noexcept {
    return statHere(AT_FDCWD, path, out, AT_SYMLINK_NOFOLLOW);
}
int fstatat(int folder, const char* path, struct stat* out, int flags) noexcept {
    return statHere(folder, path, out, flags);
}
int stat64(const char* path, struct stat64* out) noexcept {
    return statHere(AT_FDCWD, path, reinterpret_cast<struct stat*>(out), 0);  // one struct on 64-bit machines
}
int lstat64(const char* path, struct stat64* out) noexcept {
    return statHere(AT_FDCWD, path, reinterpret_cast<struct stat*>(out), AT_SYMLINK_NOFOLLOW);
}
int fstatat64(int folder, const char* path, struct stat64* out, int flags) noexcept {
    return statHere(folder, path, reinterpret_cast<struct stat*>(out), flags);
}
int statx(int folder, const char* path, int flags, unsigned mask, struct statx* out) noexcept {
    if (!isAlone || ((flags & AT_EMPTY_PATH) != 0 && *path == '\0'))
        return static_cast<int>(::syscall(SYS_statx, folder, path, flags, mask, out));
    const int kept = keptFor(path);
    return kept < 0 ? -1 : static_cast<int>(::syscall(SYS_statx, kept, "", AT_EMPTY_PATH, mask, out));
}
int access(const char* path, int kind) noexcept {
    if (!isAlone) return static_cast<int>(::syscall(SYS_faccessat, AT_FDCWD, path, kind));
    if ((kind & (W_OK | X_OK)) == 0) return keptFor(path) < 0 ? -1 : 0;
    errno = EACCES;
    return -1;
}

}  // extern "C"
