#include "formats/pending_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <string>
#include <system_error>

namespace lightcook::formats {
namespace {

tl::unexpected<Error> machineFailure(const std::filesystem::path& file, const char* step, int errorNumber) {
    return failure(ErrorCode::Internal, file.string(),
                   fmt::format("found \"{}\" while {}, expected a file system that takes it", std::strerror(errorNumber), step));
}

/// Descriptors leak on early returns otherwise.
struct Descriptor {
    int number = -1;
    ~Descriptor() {
        if (number >= 0) ::close(number);
    }
};

}  // namespace

PendingFile::PendingFile(std::filesystem::path target, std::filesystem::path temporary)
    : target_(std::move(target)), temporary_(std::move(temporary)) {}

PendingFile::PendingFile(PendingFile&& other) noexcept : target_(std::move(other.target_)), temporary_(std::move(other.temporary_)) {
    other.temporary_.clear();
}

PendingFile& PendingFile::operator=(PendingFile&& other) noexcept {
    std::swap(target_, other.target_);
    std::swap(temporary_, other.temporary_);
    return *this;
}

PendingFile::~PendingFile() {
    if (temporary_.empty()) return;
    std::error_code ignored;
    std::filesystem::remove(temporary_, ignored);
}

Result<PendingFile> PendingFile::create(const std::filesystem::path& file) {
    static std::atomic<unsigned> counter = 0;
    for (;;) {
        // open(2) and not mkstemp(3), which ignores the umask. The extension stays last: image libraries choose the format by it.
        const std::filesystem::path name =
            file.parent_path() / fmt::format(".{}.{}-{}{}", file.stem().string(), ::getpid(), counter++, file.extension().string());
        const Descriptor descriptor{::open(name.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666)};
        if (descriptor.number >= 0) return PendingFile(file, name);
        if (errno != EEXIST) return machineFailure(file, "creating it", errno);  // EEXIST: left behind by a process that was killed
    }
}

Result<void> PendingFile::commit() {
    {
        const Descriptor descriptor{::open(temporary_.c_str(), O_RDONLY | O_CLOEXEC)};
        if (descriptor.number < 0 || ::fsync(descriptor.number) != 0) return machineFailure(target_, "syncing it", errno);
    }
    if (::rename(temporary_.c_str(), target_.c_str()) != 0) return machineFailure(target_, "renaming it into place", errno);
    temporary_.clear();
    return {};
}

Result<void> writeWholeFile(const std::filesystem::path& file, std::span<const std::byte> bytes) {
    Result<PendingFile> pending = PendingFile::create(file);
    if (!pending) return tl::make_unexpected(pending.error());
    {
        const Descriptor descriptor{::open(pending->temporary().c_str(), O_WRONLY | O_CLOEXEC)};
        if (descriptor.number < 0) return machineFailure(file, "opening it", errno);
        while (!bytes.empty()) {
            const ssize_t written = ::write(descriptor.number, bytes.data(), bytes.size());
            if (written < 0 && errno == EINTR) continue;
            if (written <= 0) return machineFailure(file, "writing it", errno);
            bytes = bytes.subspan(static_cast<std::size_t>(written));
        }
    }
    return pending->commit();
}

}  // namespace lightcook::formats
