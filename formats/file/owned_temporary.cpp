#include "formats/file/owned_temporary.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/statfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <system_error>
#include <utility>

#include "formats/temporaries.h"

namespace lightcook::formats {
namespace {

namespace fs = std::filesystem;

/// A temporary folder is locked by a file of the same name with this ending, which is made before it and removed after it.
constexpr const char* kLockEnding = ".lock";
/// Longer extensions are no image format, and the name has to stay below 256 bytes.
constexpr std::size_t kLongestExtension = 16;
/// A folder without a lock file is none of this version of the program.
constexpr std::chrono::hours kUnlockedAge{1}, kNetworkAge{24};

/// Temporaries of the process. Never destroyed: a signal may come while static objects are.
struct Registry {
    std::recursive_mutex mutex;
    std::map<fs::path, std::vector<fs::path>> paths;  ///< with the parents that were made for each, the deepest first
    bool isStopped = false;
};
Registry& registry() {
    static Registry& only = *new Registry;
    return only;
}

void enlist(const fs::path& path, const std::vector<fs::path>& madeParents) {
    const std::lock_guard lock(registry().mutex);
    registry().paths[path] = madeParents;
}

void removeEmpty(const std::vector<fs::path>& folders) {
    std::error_code ignored;
    for (const fs::path& folder : folders)
        if (fs::is_empty(folder, ignored)) fs::remove(folder, ignored);
}

enum class Lock { Taken, Elsewhere, Unsupported };

/// Locks what a descriptor refers to, without waiting.
Lock tryLock(int descriptor) {
    if (::flock(descriptor, LOCK_EX | LOCK_NB) == 0) return Lock::Taken;
    return errno == EWOULDBLOCK ? Lock::Elsewhere : Lock::Unsupported;
}

/// Keeps a new temporary's descriptor as its lock. Returns nothing if removeLeftovers() of another process was faster.
std::optional<int> keepLock(int descriptor) {
    const Lock lock = tryLock(descriptor);
    struct stat status {};
    if (lock == Lock::Elsewhere || ::fstat(descriptor, &status) != 0 || status.st_nlink == 0) {
        ::close(descriptor);
        return std::nullopt;
    }
    if (lock == Lock::Taken) return descriptor;
    ::close(descriptor);
    return -1;
}

/// Returns true on file systems whose locks may hold on one machine only.
bool isOnNetwork(const fs::path& folder) {
    struct statfs status {};
    if (::statfs(folder.c_str(), &status) != 0) return true;
    // NFS, SMB (three generations), FUSE, Ceph, 9P, Lustre, AFS
    constexpr std::array<std::uint32_t, 9> kTypes = {0x6969,     0x517b,     0xff534d42, 0xfe534d42, 0x65735546,
                                                     0x00c36400, 0x01021997, 0x0bd00bd0, 0x5346414f};
    return std::find(kTypes.begin(), kTypes.end(), static_cast<std::uint32_t>(status.f_type)) != kTypes.end();
}

bool isOlderThan(const struct stat& status, std::chrono::hours age) {
    return std::chrono::system_clock::now() - std::chrono::system_clock::from_time_t(status.st_mtim.tv_sec) > age;
}

/// Removes a temporary of this user if no process owns it.
void removeIfLeftOver(const fs::path& path, bool isNetwork) {
    struct stat status {};
    if (::lstat(path.c_str(), &status) != 0 || status.st_uid != ::geteuid() || (isNetwork && !isOlderThan(status, kNetworkAge))) return;
    std::error_code ignored;
    if (S_ISDIR(status.st_mode) && !fs::exists(path.string() + kLockEnding, ignored) && isOlderThan(status, kUnlockedAge))
        fs::remove_all(path, ignored);
    if (!S_ISREG(status.st_mode)) return;
    const int descriptor = ::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
    if (descriptor < 0) return;
    if (tryLock(descriptor) == Lock::Taken) {
        if (path.extension() == kLockEnding) fs::remove_all(fs::path(path).replace_extension(), ignored);
        fs::remove(path, ignored);
    }
    ::close(descriptor);
}

}  // namespace

tl::unexpected<Error> outputFailure(const fs::path& file, const char* step, int errorNumber) {
    if (errorNumber == ENAMETOOLONG)
        return failure(ErrorCode::InvalidRequest, file.string(),
                       "found a name that is too long, expected at most 255 bytes a name and 4095 a path");
    const bool isMistake = errorNumber == EISDIR || errorNumber == ELOOP;
    const bool isForbidden = errorNumber == EACCES || errorNumber == EPERM || errorNumber == EROFS;
    const bool isFull = errorNumber == ENOSPC || errorNumber == EDQUOT;
    const char* expected = isForbidden ? "a folder that this user may write to: change its permissions, or name another"
                           : isFull    ? "more free space, or another folder"
                                       : "a file system that takes it";
    return failure(isMistake ? ErrorCode::InvalidRequest : ErrorCode::Internal, file.string(),
                   fmt::format("found \"{}\" while {}, expected {}", std::strerror(errorNumber), step, expected));
}

Result<OutputTransaction> OutputTransaction::begin() {
    std::unique_lock lock(registry().mutex);
    if (registry().isStopped) return failure(ErrorCode::Interrupted, "output", "interrupted");
    return OutputTransaction(std::move(lock));
}

void stopOutputs() {
    const std::lock_guard lock(registry().mutex);
    registry().isStopped = true;
}

void abandonTemporaries() {
    registry().mutex.lock();  // for ever
    std::error_code ignored;
    for (const auto& [path, madeParents] : registry().paths)
        // Threads that write may still add a file while the folder is emptied.
        for (int attempt = 0; attempt < 3 && fs::exists(path, ignored); ++attempt) fs::remove_all(path, ignored);
    for (const auto& [path, madeParents] : registry().paths) removeEmpty(madeParents);
}

void removeLeftovers(const fs::path& folder) {
    std::error_code code;
    const fs::directory_iterator entries(folder, code);
    if (code) return;
    std::optional<bool> isNetwork;
    for (const fs::directory_entry& entry : entries) {
        if (!entry.path().filename().string().starts_with(kTemporaryPrefix)) continue;
        if (!isNetwork) isNetwork = isOnNetwork(folder);
        removeIfLeftOver(entry.path(), *isNetwork);
    }
}

Result<OwnedTemporary> OwnedTemporary::makeFile(const fs::path& folder, const fs::path& extension, const char* step) {
    static std::atomic<unsigned> counter = 0;
    const std::string ending = extension.string().size() <= kLongestExtension ? extension.string() : "";
    for (;;) {
        std::unique_lock enlisting(registry().mutex);  // abandonTemporaries() sees what exists
        // open(2) and not mkstemp(3), which ignores the umask.
        const fs::path path = folder / fmt::format("{}{}-{}{}", kTemporaryPrefix, ::getpid(), counter++, ending);
        const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (descriptor < 0) {
            if (errno == EEXIST) continue;  // of a process with our number, in another container or before
            return outputFailure(path, step, errno);
        }
        enlist(path, {});
        enlisting.unlock();
        if (const auto lock = keepLock(descriptor)) return OwnedTemporary(path, *lock);
    }
}

Result<OwnedTemporary> OwnedTemporary::makeFolder(const fs::path& parent) {
    const std::lock_guard enlisting(registry().mutex);  // abandonTemporaries() sees what exists
    std::vector<fs::path> missing;
    std::error_code code;
    for (fs::path each = parent; !each.empty() && !fs::exists(each, code); each = each.parent_path()) missing.push_back(each);
    code.clear();
    fs::create_directories(parent, code);
    constexpr const char* kStep = "making a temporary folder in it";
    const auto refuse = [&](int errorNumber) {
        removeEmpty(missing);
        return outputFailure(parent, kStep, errorNumber);
    };
    if (code) return refuse(code.value());
    for (;;) {
        auto lockFile = makeFile(parent, kLockEnding, kStep);
        if (!lockFile) {
            removeEmpty(missing);
            return failure(lockFile.error().code, parent.string(), lockFile.error().detail);
        }
        const fs::path path = fs::path(lockFile->path()).replace_extension();
        if (::mkdir(path.c_str(), 0700) != 0) {
            if (errno == EEXIST) continue;
            return refuse(errno);
        }
        enlist(path, missing);
        return OwnedTemporary(path, std::make_unique<OwnedTemporary>(std::move(*lockFile)), std::move(missing));
    }
}

OwnedTemporary::OwnedTemporary(fs::path path, std::unique_ptr<OwnedTemporary> lockFile, std::vector<fs::path> madeParents)
    : path_(std::move(path)), lockFile_(std::move(lockFile)), madeParents_(std::move(madeParents)) {}

OwnedTemporary::OwnedTemporary(OwnedTemporary&& other) noexcept
    : path_(std::exchange(other.path_, {})),
      lock_(std::exchange(other.lock_, -1)),
      lockFile_(std::move(other.lockFile_)),
      madeParents_(std::exchange(other.madeParents_, {})) {}

OwnedTemporary& OwnedTemporary::operator=(OwnedTemporary&& other) noexcept {
    std::swap(path_, other.path_);
    std::swap(lock_, other.lock_);
    std::swap(lockFile_, other.lockFile_);
    std::swap(madeParents_, other.madeParents_);
    return *this;
}

OwnedTemporary::~OwnedTemporary() {
    if (!path_.empty()) {
        std::error_code ignored;
        fs::remove_all(path_, ignored);
        lockFile_.reset();
        removeEmpty(madeParents_);
        const std::lock_guard lock(registry().mutex);
        registry().paths.erase(path_);
    }
    if (lock_ >= 0) ::close(lock_);
}

Result<void> OwnedTemporary::renameTo(const fs::path& file) {
    const std::lock_guard lock(registry().mutex);
    if (registry().isStopped) return failure(ErrorCode::Interrupted, file.string(), "interrupted");
    if (::rename(path_.c_str(), file.c_str()) != 0) return outputFailure(file, "renaming it into place", errno);
    registry().paths.erase(path_);
    path_.clear();
    return {};
}

}  // namespace lightcook::formats
