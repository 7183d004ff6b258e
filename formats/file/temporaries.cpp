#include "formats/temporaries.h"

#include "formats/system_calls.h"

#include <dirent.h>
#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstring>
#include <map>
#include <new>
#include <string_view>
#include <system_error>
#include <utility>

namespace lightcook::formats {
namespace {

namespace fs = std::filesystem;

/// Longer extensions are no image format, and the name has to stay below 256 bytes.
constexpr std::size_t kLongestExtension = 16;

/// Temporaries of the process. Never destroyed: a signal may come while static objects are. Made without the heap: the first to ask may be
/// the end of a process without memory.
struct Registry {
    std::mutex mutex;
    std::map<fs::path, std::vector<fs::path>> paths;  ///< with the parents that were made for each, the deepest first
    std::mutex appearing;                             ///< held while outputs appear together
    std::atomic<bool> isStopped{false};
};
Registry& registry() {
    alignas(Registry) static std::array<std::byte, sizeof(Registry)> place;
    static Registry* const only = ::new (place.data()) Registry;
    return *only;
}

// What removes temporaries allocates nothing and throws nothing: it runs in destructors, and when memory has run out.

void removeEmpty(const std::vector<fs::path>& folders) {
    for (const fs::path& folder : folders) ::rmdir(folder.c_str());  // fails unless it is empty
}

void removeTree(int parent, const char* name);

/// Removes what a folder holds.
void removeContent(int folder) {
    alignas(dirent64) char buffer[4096];
    ::lseek(folder, 0, SEEK_SET);
    for (ssize_t count = 0; (count = ::getdents64(folder, buffer, sizeof buffer)) > 0;)
        for (ssize_t at = 0; at < count;) {
            const auto* const entry = reinterpret_cast<const dirent64*>(buffer + at);
            const std::string_view name = entry->d_name;
            if (name != "." && name != "..") removeTree(folder, entry->d_name);
            at += entry->d_reclen;
        }
}

/// Removes a file, or a folder with all that it holds. Of a symbolic link only the link goes.
/// parent   descriptor of the folder that holds it; AT_FDCWD: the path is that of the process
void removeTree(int parent, const char* name) {
    if (::unlinkat(parent, name, 0) == 0 || (errno != EISDIR && errno != EPERM)) return;
    // Threads that write may still add a file while the folder is emptied, and a descriptor may be free a moment later.
    for (int attempt = 0; attempt < 3 && ::unlinkat(parent, name, AT_REMOVEDIR) != 0; ++attempt) {
        const int folder = retried([&] { return ::openat(parent, name, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC); });
        if (folder < 0) continue;
        removeContent(folder);
        ::close(folder);
    }
}

/// Takes a lock within a second. Returns false if another thread keeps it, or this one has it.
bool takeInTime(std::mutex& mutex) {
    for (int attempt = 0; attempt < 1000; ++attempt) {
        if (mutex.try_lock()) return true;
        ::usleep(1000);
    }
    return false;
}

}  // namespace

tl::unexpected<Error> outputFailure(const fs::path& file, const char* step, int errorNumber) {
    if (errorNumber == ENAMETOOLONG)
        return failure(ErrorCode::InvalidRequest, file, "found a name that is too long, expected at most 255 bytes a name and 4095 a path");
    const bool isMistake = errorNumber == EISDIR || errorNumber == ELOOP;
    const bool isForbidden = errorNumber == EACCES || errorNumber == EPERM || errorNumber == EROFS;
    const bool isFull = errorNumber == ENOSPC || errorNumber == EDQUOT;
    const char* expected = isForbidden ? "a folder that this user may write to: change its permissions, or name another"
                           : isFull    ? "more free space, or another folder"
                                       : "a file system that takes it";
    return failure(isMistake ? ErrorCode::InvalidRequest : ErrorCode::Internal, file,
                   fmt::format("found \"{}\" while {}, expected {}", std::strerror(errorNumber), step, expected));
}

Result<OutputTransaction> OutputTransaction::begin() {
    std::unique_lock lock(registry().appearing);
    if (areOutputsStopped()) return failure(ErrorCode::Interrupted, "output", "interrupted");
    return OutputTransaction(std::move(lock));
}

void stopOutputs() {
    const bool isTaken = takeInTime(registry().appearing);
    registry().isStopped = true;
    if (isTaken) registry().appearing.unlock();
}

bool areOutputsStopped() {
    return registry().isStopped;
}

void abandonTemporaries() {
    if (!takeInTime(registry().mutex)) return;  // for ever
    for (const auto& [path, madeParents] : registry().paths) removeTree(AT_FDCWD, path.c_str());
    for (const auto& [path, madeParents] : registry().paths) removeEmpty(madeParents);
}

void removeOldTemporaries(const fs::path& folder) {
    std::error_code code;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, code)) {
        const auto changed = entry.last_write_time(code);
        const bool isOld = !code && fs::file_time_type::clock::now() - changed > std::chrono::hours(24);
        if (isOld && entry.path().filename().string().starts_with(kTemporaryPrefix)) fs::remove_all(entry.path(), code);
    }
}

Result<Temporary> Temporary::make(Temporary made, const fs::path& folder, const std::string& ending, Make make, const char* step) {
    static std::atomic<unsigned> counter = 0;
    for (;;) {
        fs::path path = folder / fmt::format("{}{}-{}{}", kTemporaryPrefix, ::getpid(), counter++, ending);
        std::map<fs::path, std::vector<fs::path>> rows;
        rows.emplace(path, made.madeParents_);
        auto node = rows.extract(rows.begin());
        // abandonTemporaries() sees what exists. Nothing is allocated under the lock: where memory runs out, that function is called.
        std::unique_lock enlisting(registry().mutex);
        const auto row = registry().paths.insert(std::move(node));
        if (row.inserted && make(path.c_str())) {
            made.path_ = std::move(path);
            return made;
        }
        const int errorNumber = row.inserted ? errno : EEXIST;
        if (row.inserted) registry().paths.erase(row.position);
        if (errorNumber == EEXIST) continue;  // of a process with our number, in another container or before
        enlisting.unlock();
        return outputFailure(folder, step, errorNumber);
    }
}

Result<Temporary> Temporary::makeFile(const fs::path& folder, const fs::path& extension) {
    const auto create = [](const char* path) {
        // open(2) and not mkstemp(3), which ignores the umask.
        const int descriptor = retried([path] { return ::open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666); });
        return descriptor >= 0 && ::close(descriptor) == 0;
    };
    return make({}, folder, extension.string().size() <= kLongestExtension ? extension.string() : "", create, "creating it");
}

Result<Temporary> Temporary::makeFolder(const fs::path& parent) {
    Temporary made;  // removes the parents again unless it is made
    std::error_code code;
    for (fs::path each = parent; !each.empty() && !fs::exists(each, code); each = each.parent_path()) made.madeParents_.push_back(each);
    code.clear();
    fs::create_directories(parent, code);
    constexpr const char* kStep = "making a temporary folder in it";
    if (code) return outputFailure(parent, kStep, code.value());
    return make(
        std::move(made), parent, "", [](const char* path) { return ::mkdir(path, 0700) == 0; }, kStep);
}

Temporary& Temporary::operator=(Temporary&& other) noexcept {
    std::swap(path_, other.path_);
    std::swap(madeParents_, other.madeParents_);
    return *this;
}

Temporary::~Temporary() {
    if (!path_.empty()) removeTree(AT_FDCWD, path_.c_str());
    removeEmpty(madeParents_);
    if (path_.empty()) return;
    const std::lock_guard lock(registry().mutex);
    registry().paths.erase(path_);
}

Result<void> Temporary::renameTo(const fs::path& file) {
    if (areOutputsStopped()) return failure(ErrorCode::Interrupted, file, "interrupted");
    if (::rename(path_.c_str(), file.c_str()) != 0) return outputFailure(file, "renaming it into place", errno);
    const std::lock_guard lock(registry().mutex);
    registry().paths.erase(path_);
    path_.clear();
    return {};
}

}  // namespace lightcook::formats
