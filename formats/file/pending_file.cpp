#include "formats/pending_file.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <optional>
#include <set>
#include <string>
#include <system_error>

#include "formats/file/owned_temporary.h"
#include "formats/process.h"
#include "formats/temporaries.h"

namespace lightcook::formats {
namespace {

constexpr int kMostLinks = 40;  ///< as Linux follows

/// Descriptors leak on early returns otherwise.
struct Descriptor {
    int number = -1;
    ~Descriptor() {
        if (number >= 0) ::close(number);
    }
};

/// Opens a stream for writing: descriptors of this process share their place in the file, sockets are connected to.
int openStream(const std::filesystem::path& path) {
    if (const auto number = ownDescriptor(path)) {
        if (*number == STDOUT_FILENO) std::fflush(stdout);
        return ::fcntl(*number, F_DUPFD_CLOEXEC, 0);
    }
    struct stat status {};
    if (::stat(path.c_str(), &status) != 0 || !S_ISSOCK(status.st_mode)) return ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    const std::string name = path.string();
    if (name.size() >= sizeof address.sun_path) {
        errno = ENAMETOOLONG;
        return -1;
    }
    name.copy(address.sun_path, name.size());
    Descriptor socket{::socket(AF_UNIX, SOCK_STREAM, 0)};
    if (socket.number < 0 || ::fcntl(socket.number, F_SETFD, FD_CLOEXEC) != 0 ||
        ::connect(socket.number, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0)
        return -1;
    return std::exchange(socket.number, -1);
}

/// Writes all bytes; returns the error of the system, or 0.
int writeAll(int descriptor, std::span<const std::byte> bytes) {
    while (!bytes.empty()) {
        const ssize_t written = ::write(descriptor, bytes.data(), bytes.size());
        if (written < 0 && errno == EINTR) continue;
        if (written <= 0) return written < 0 ? errno : ENOSPC;
        bytes = bytes.subspan(static_cast<std::size_t>(written));
    }
    return 0;
}

/// Copies a complete file into a stream.
Result<void> pour(const std::filesystem::path& from, const std::filesystem::path& stream, const std::filesystem::path& shownAs) {
    const Descriptor source{::open(from.c_str(), O_RDONLY | O_CLOEXEC)}, sink{openStream(stream)};
    if (source.number < 0 || sink.number < 0) return outputFailure(shownAs, "opening it", errno);
    std::array<std::byte, 1 << 16> buffer;
    while (true) {
        const ssize_t count = ::read(source.number, buffer.data(), buffer.size());
        if (count < 0 && errno == EINTR) continue;
        if (count < 0) return outputFailure(shownAs, "reading its content back", errno);
        if (count == 0) return {};
        if (const int error = writeAll(sink.number, std::span(buffer).first(static_cast<std::size_t>(count))); error != 0)
            return outputFailure(shownAs, "writing it", error);
    }
}

/// Removes what killed processes left in a folder, once a process.
void removeLeftoversOnce(const std::filesystem::path& folder) {
    static std::mutex mutex;
    static std::set<std::filesystem::path> done;
    const std::lock_guard lock(mutex);
    if (done.insert(folder).second) removeLeftovers(folder.empty() ? "." : folder);
}

}  // namespace

Result<OutputPlace> findOutputPlace(const std::filesystem::path& file, OutputLink link) {
    std::filesystem::path path = file;
    for (int links = 0; links < kMostLinks; ++links) {
        struct stat status {};
        if (::lstat(path.c_str(), &status) != 0) {
            if (errno == ENOENT) return OutputPlace{path, false};
            return outputFailure(file, "looking it up", errno);
        }
        if (S_ISDIR(status.st_mode))
            return failure(ErrorCode::InvalidRequest, file.string(), "found a folder, expected the name of a file to write");
        if (!S_ISLNK(status.st_mode)) return OutputPlace{path, !S_ISREG(status.st_mode)};
        if (descriptorFolder(path)) return OutputPlace{path, true};
        if (link == OutputLink::Replace) return OutputPlace{path, false};
        std::error_code code;
        path = path.parent_path() / std::filesystem::read_symlink(path, code);  // an absolute link replaces the folder
        if (code) return outputFailure(file, "following its link", code.value());
    }
    return outputFailure(file, "following its links", ELOOP);
}

PendingFile::PendingFile(std::filesystem::path target, OutputPlace place, std::unique_ptr<OwnedTemporary> temporary)
    : target_(std::move(target)), place_(std::move(place)), temporary_(std::move(temporary)) {}
PendingFile::PendingFile(PendingFile&&) noexcept = default;
PendingFile& PendingFile::operator=(PendingFile&&) noexcept = default;
PendingFile::~PendingFile() = default;

const std::filesystem::path& PendingFile::temporary() const {
    return temporary_->path();
}

Result<PendingFile> PendingFile::create(const std::filesystem::path& file, OutputLink link) {
    auto place = findOutputPlace(file, link);
    if (!place) return tl::make_unexpected(place.error());
    std::error_code code;
    const std::filesystem::path folder = place->isStream ? std::filesystem::temp_directory_path(code) : place->path.parent_path();
    if (code)
        return failure(ErrorCode::Internal, "TMPDIR", fmt::format("found '{}', expected a folder for temporary files", code.message()));
    removeLeftoversOnce(folder);
    auto temporary = OwnedTemporary::makeFile(folder, file.extension());
    if (!temporary) {
        Error error = temporary.error();
        error.subject = file.string();
        return tl::make_unexpected(std::move(error));
    }
    return PendingFile(file, std::move(*place), std::make_unique<OwnedTemporary>(std::move(*temporary)));
}

Result<void> PendingFile::commit() {
    if (place_.isStream) {
        {
            const auto transaction = OutputTransaction::begin();
            if (!transaction) return tl::make_unexpected(transaction.error());
        }
        // Not inside the transaction: the reader of a FIFO may never come.
        auto written = pour(temporary(), place_.path, target_);
        temporary_.reset();
        return written;
    }
    if (!isSynced_) {
        const Descriptor descriptor{::open(temporary().c_str(), O_RDONLY | O_CLOEXEC)};
        if (descriptor.number < 0 || ::fsync(descriptor.number) != 0) return outputFailure(target_, "syncing it", errno);
    }
    auto renamed = temporary_->renameTo(place_.path);
    if (!renamed) return failure(renamed.error().code, target_.string(), renamed.error().detail);
    temporary_.reset();
    return {};
}

Result<PendingFile> prepareWholeFile(const std::filesystem::path& file, std::span<const std::byte> bytes, OutputLink link) {
    Result<PendingFile> pending = PendingFile::create(file, link);
    if (!pending) return pending;
    {
        const Descriptor descriptor{::open(pending->temporary().c_str(), O_WRONLY | O_CLOEXEC)};
        if (descriptor.number < 0) return outputFailure(file, "opening it", errno);
        if (const int error = writeAll(descriptor.number, bytes); error != 0) return outputFailure(file, "writing it", error);
        if (::fsync(descriptor.number) != 0) return outputFailure(file, "syncing it", errno);
    }
    pending->isSynced_ = true;
    return pending;
}

Result<void> writeWholeFile(const std::filesystem::path& file, std::span<const std::byte> bytes, OutputLink link) {
    auto pending = prepareWholeFile(file, bytes, link);
    if (!pending) return tl::make_unexpected(pending.error());
    return pending->commit();
}

}  // namespace lightcook::formats
