#include "formats/temporaries.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <map>
#include <system_error>
#include <utility>

namespace lightcook::formats {
namespace {

namespace fs = std::filesystem;

/// Longer extensions are no image format, and the name has to stay below 256 bytes.
constexpr std::size_t kLongestExtension = 16;

/// Temporaries of the process. Never destroyed: a signal may come while static objects are.
struct Registry {
    std::mutex mutex;
    std::map<fs::path, std::vector<fs::path>> paths;  ///< with the parents that were made for each, the deepest first
    std::mutex appearing;                             ///< held while outputs appear together
    std::atomic<bool> isStopped{false};
};
Registry& registry() {
    static Registry& only = *new Registry;
    return only;
}

void removeEmpty(const std::vector<fs::path>& folders) {
    std::error_code ignored;
    for (const fs::path& folder : folders)
        if (fs::is_empty(folder, ignored)) fs::remove(folder, ignored);
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
    const std::lock_guard lock(registry().appearing);
    registry().isStopped = true;
}

bool areOutputsStopped() {
    return registry().isStopped;
}

void abandonTemporaries() {
    registry().mutex.lock();  // for ever
    std::error_code ignored;
    for (const auto& [path, madeParents] : registry().paths)
        // Threads that write may still add a file while the folder is emptied.
        for (int attempt = 0; attempt < 3 && fs::exists(path, ignored); ++attempt) fs::remove_all(path, ignored);
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

Result<Temporary> Temporary::make(const fs::path& folder, const std::string& ending, Make make, const char* step,
                                  std::vector<fs::path> madeParents) {
    static std::atomic<unsigned> counter = 0;
    for (;;) {
        const std::lock_guard enlisting(registry().mutex);  // abandonTemporaries() sees what exists
        Temporary made;
        made.path_ = folder / fmt::format("{}{}-{}{}", kTemporaryPrefix, ::getpid(), counter++, ending);
        if (make(made.path_.c_str())) {
            registry().paths[made.path_] = madeParents;
            made.madeParents_ = std::move(madeParents);
            return made;
        }
        made.path_.clear();
        if (errno == EEXIST) continue;  // of a process with our number, in another container or before
        const int errorNumber = errno;
        removeEmpty(madeParents);
        return outputFailure(folder, step, errorNumber);
    }
}

Result<Temporary> Temporary::makeFile(const fs::path& folder, const fs::path& extension) {
    const auto create = [](const char* path) {
        // open(2) and not mkstemp(3), which ignores the umask.
        const int descriptor = ::open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        return descriptor >= 0 && ::close(descriptor) == 0;
    };
    return make(folder, extension.string().size() <= kLongestExtension ? extension.string() : "", create, "creating it", {});
}

Result<Temporary> Temporary::makeFolder(const fs::path& parent) {
    std::vector<fs::path> missing;
    std::error_code code;
    for (fs::path each = parent; !each.empty() && !fs::exists(each, code); each = each.parent_path()) missing.push_back(each);
    code.clear();
    fs::create_directories(parent, code);
    constexpr const char* kStep = "making a temporary folder in it";
    if (code) {
        removeEmpty(missing);
        return outputFailure(parent, kStep, code.value());
    }
    return make(
        parent, "", [](const char* path) { return ::mkdir(path, 0700) == 0; }, kStep, std::move(missing));
}

Temporary& Temporary::operator=(Temporary&& other) noexcept {
    std::swap(path_, other.path_);
    std::swap(madeParents_, other.madeParents_);
    return *this;
}

Temporary::~Temporary() {
    if (path_.empty()) return;
    std::error_code ignored;
    fs::remove_all(path_, ignored);
    removeEmpty(madeParents_);
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
