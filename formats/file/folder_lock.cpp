#include "formats/folder_lock.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <utility>

namespace lightcook::formats {

std::optional<FolderLock> FolderLock::take(const std::filesystem::path& folder) {
    // Between open(2) and flock(2) the folder may be removed and made anew; on file systems whose inodes change, isOf() is never true.
    for (int attempt = 0; attempt < 100; ++attempt) {
        FolderLock lock(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
        if (lock.descriptor_ < 0) return lock;
        if (::flock(lock.descriptor_, LOCK_EX | LOCK_NB) != 0) {
            if (errno == EWOULDBLOCK) return std::nullopt;
            return FolderLock(-1);
        }
        std::error_code code;
        if (lock.isOf(folder) || !std::filesystem::exists(folder, code)) return lock;
    }
    return FolderLock(-1);
}

FolderLock::FolderLock(FolderLock&& other) noexcept : descriptor_(std::exchange(other.descriptor_, -1)) {}

FolderLock& FolderLock::operator=(FolderLock&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    return *this;
}

FolderLock::~FolderLock() {
    if (descriptor_ >= 0) ::close(descriptor_);
}

bool FolderLock::isOf(const std::filesystem::path& folder) const {
    struct stat locked {
    }, named{};
    return descriptor_ >= 0 && ::fstat(descriptor_, &locked) == 0 && ::stat(folder.c_str(), &named) == 0 && locked.st_dev == named.st_dev &&
           locked.st_ino == named.st_ino;
}

}  // namespace lightcook::formats
