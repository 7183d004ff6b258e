#include "formats/file/file_bytes.h"

#include "formats/file/file_kind.h"
#include "formats/system_calls.h"
#include "formats/temporaries.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <cstring>
#include <utility>

namespace lightcook::formats {
namespace {

// One system call moves at most 0x7ffff000 bytes on Linux; 1 GiB stays under it everywhere.
constexpr std::size_t kLargestTransfer = std::size_t{1} << 30;

tl::unexpected<Error> readFailure(const std::filesystem::path& file, const char* step, int errorNumber) {
    return failure(ErrorCode::FileUnreadable, file,
                   fmt::format("found \"{}\" while {}, expected a readable file", std::strerror(errorNumber), step));
}

}  // namespace

FileBytes::FileBytes(int descriptor, std::filesystem::path shownAs, std::uint64_t size)
    : descriptor_(descriptor), shownAs_(std::move(shownAs)), size_(size) {}

FileBytes::FileBytes(FileBytes&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)), shownAs_(std::move(other.shownAs_)), size_(other.size_) {}

FileBytes& FileBytes::operator=(FileBytes&& other) noexcept {
    std::swap(descriptor_, other.descriptor_);
    std::swap(shownAs_, other.shownAs_);
    std::swap(size_, other.size_);
    return *this;
}

FileBytes::~FileBytes() {
    close();
}

void FileBytes::close() {
    if (descriptor_ >= 0) ::close(std::exchange(descriptor_, -1));
}

Result<FileBytes> FileBytes::openForReading(const std::filesystem::path& file) {
    // Not blocked by a FIFO without a writer.
    const int descriptor = retried([&] { return ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK); });
    if (descriptor < 0) return readFailure(file, "opening it", errno);
    FileBytes opened(descriptor, file, 0);
    struct stat status {};
    if (::fstat(descriptor, &status) != 0) return readFailure(file, "asking for its size", errno);
    if (!S_ISREG(status.st_mode))
        return failure(ErrorCode::FileUnreadable, file,
                       fmt::format("found {}, expected a regular file", whyNoFile(file).value_or("something else")));
    opened.size_ = static_cast<std::uint64_t>(status.st_size);
    return opened;
}

Result<FileBytes> FileBytes::openForUpdate(const std::filesystem::path& file, const std::filesystem::path& shownAs) {
    const int descriptor = retried([&] { return ::open(file.c_str(), O_RDWR | O_CLOEXEC); });
    if (descriptor < 0) return outputFailure(shownAs, "opening it", errno);
    return FileBytes(descriptor, shownAs, 0);
}

Result<void> FileBytes::readAt(std::uint64_t offset, std::span<std::byte> out) const {
    while (!out.empty()) {
        const std::size_t wanted = std::min(out.size(), kLargestTransfer);
        const ssize_t count = retried([&] { return ::pread(descriptor_, out.data(), wanted, static_cast<off_t>(offset)); });
        if (count < 0) return readFailure(shownAs_, fmt::format("reading byte {}", offset).c_str(), errno);
        if (count == 0)
            return failure(ErrorCode::FileUnreadable, shownAs_,
                           fmt::format("found the end of the file at byte {}, expected {} bytes more", offset, out.size()));
        offset += static_cast<std::uint64_t>(count);
        out = out.subspan(static_cast<std::size_t>(count));
    }
    return {};
}

Result<void> FileBytes::writeAt(std::uint64_t offset, std::span<const std::byte> bytes) const {
    while (!bytes.empty()) {
        const std::size_t wanted = std::min(bytes.size(), kLargestTransfer);
        const ssize_t count = retried([&] { return ::pwrite(descriptor_, bytes.data(), wanted, static_cast<off_t>(offset)); });
        if (count <= 0) return outputFailure(shownAs_, fmt::format("writing byte {}", offset).c_str(), count < 0 ? errno : ENOSPC);
        offset += static_cast<std::uint64_t>(count);
        bytes = bytes.subspan(static_cast<std::size_t>(count));
    }
    return {};
}

Result<void> FileBytes::resize(std::uint64_t bytes) {
    if (retried([&] { return ::ftruncate(descriptor_, static_cast<off_t>(bytes)); }) != 0)
        return outputFailure(shownAs_, "setting its size", errno);
    size_ = bytes;
    return {};
}

Result<void> FileBytes::sync() const {
    if (retried([&] { return ::fsync(descriptor_); }) != 0) return outputFailure(shownAs_, "syncing it", errno);
    return {};
}

std::uint32_t loadU32(std::span<const std::byte> bytes, std::size_t offset) {
    assert(offset + 4 <= bytes.size());
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value |= std::to_integer<std::uint32_t>(bytes[offset + i]) << (8 * i);
    return value;
}

std::uint64_t loadU64(std::span<const std::byte> bytes, std::size_t offset) {
    return loadU32(bytes, offset) | std::uint64_t{loadU32(bytes, offset + 4)} << 32;
}

void appendU32(std::vector<std::byte>& bytes, std::uint32_t value) {
    for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<std::byte>(value >> shift & 0xff));
}

void appendU64(std::vector<std::byte>& bytes, std::uint64_t value) {
    appendU32(bytes, static_cast<std::uint32_t>(value));
    appendU32(bytes, static_cast<std::uint32_t>(value >> 32));
}

}  // namespace lightcook::formats
