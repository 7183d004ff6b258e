#include "formats/pending_file.h"

#include <fmt/format.h>

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <vector>

#include "formats/file/file_bytes.h"
#include "formats/system_calls.h"
#include "formats/temporary_folder.h"

namespace lightcook::formats {
namespace {

constexpr int kMostLinks = 40;  ///< as Linux follows
/// Opened anew it would have a place of its own in the file that standard output was redirected to.
constexpr const char* kOwnOutput = "/dev/stdout";

/// Calls write(offset, bytes), which returns a Result<void>, with each piece of a file.
template <class Write>
Result<void> forEachPiece(const FileBytes& file, Write write) {
    constexpr std::uint64_t kPieceBytes = std::uint64_t{1} << 20;
    std::vector<std::byte> piece(std::min(kPieceBytes, file.size()));
    for (std::uint64_t offset = 0; offset < file.size(); offset += piece.size()) {
        piece.resize(std::min(kPieceBytes, file.size() - offset));
        LC_CHECK(file.readAt(offset, piece));
        LC_CHECK(write(offset, std::span<const std::byte>(piece)));
    }
    return {};
}

/// Writes a complete file into a stream.
Result<void> pour(const std::filesystem::path& from, const std::filesystem::path& stream, const std::filesystem::path& shownAs) {
    LC_TRY(source, FileBytes::openForReading(from));
    const bool isOwn = stream == kOwnOutput;
    const int sink = isOwn ? STDOUT_FILENO : retried([&] { return ::open(stream.c_str(), O_WRONLY | O_CLOEXEC); });
    if (sink < 0) return outputFailure(shownAs, "opening it", errno);
    auto poured = forEachPiece(*source, [&](std::uint64_t /*offset*/, std::span<const std::byte> piece) -> Result<void> {
        if (!writeWhole(sink, {reinterpret_cast<const char*>(piece.data()), piece.size()}))
            return outputFailure(shownAs, "writing it", errno);
        return {};
    });
    if (!isOwn) ::close(sink);
    return poured;
}

}  // namespace

Result<OutputPlace> findOutputPlace(const std::filesystem::path& file, OutputLink link) {
    namespace fs = std::filesystem;
    std::error_code code;
    const bool isFollowed = link == OutputLink::Follow;
    if (file == kOwnOutput || fs::is_other(isFollowed ? fs::status(file, code) : fs::symlink_status(file, code)))
        return OutputPlace{file, true};
    fs::path path = file;
    for (int links = 0; isFollowed && fs::is_symlink(path, code); ++links) {
        if (links == kMostLinks) return outputFailure(file, "following its links", ELOOP);
        path = path.parent_path() / fs::read_symlink(path, code);  // an absolute link replaces the folder
    }
    const fs::file_status status = fs::symlink_status(path, code);
    if (status.type() == fs::file_type::none) return outputFailure(file, "looking it up", code.value());
    if (fs::is_directory(status)) return failure(ErrorCode::InvalidRequest, file, "found a folder, expected the name of a file to write");
    return OutputPlace{path, false};
}

Result<PendingFile> PendingFile::create(const std::filesystem::path& file, OutputLink link) {
    LC_TRY(place, findOutputPlace(file, link));
    LC_TRY(folder, place->isStream ? systemTemporaryFolder() : Result<std::filesystem::path>(place->path.parent_path()));
    auto temporary = Temporary::makeFile(*folder, file.extension());
    if (!temporary) return failure(temporary.error().code, file, temporary.error().detail);
    return PendingFile(file, std::move(*place), std::move(*temporary));
}

Result<void> PendingFile::commit() {
    if (place_.isStream) {
        if (areOutputsStopped()) return failure(ErrorCode::Interrupted, target_, "interrupted");
        return pour(temporary(), place_.path, target_);
    }
    if (!isSynced_) {
        LC_TRY(opened, FileBytes::openForUpdate(temporary(), target_));
        LC_CHECK(opened->sync());
    }
    auto renamed = temporary_.renameTo(place_.path);
    if (!renamed) return failure(renamed.error().code, target_, renamed.error().detail);
    return {};
}

Result<void> PendingFile::copyFrom(const std::filesystem::path& source) const {
    LC_TRY(from, FileBytes::openForReading(source));
    LC_TRY(to, FileBytes::openForUpdate(temporary(), target_));
    return forEachPiece(*from, [&](std::uint64_t offset, std::span<const std::byte> piece) { return to->writeAt(offset, piece); });
}

Result<PendingFile> prepareWholeFile(const std::filesystem::path& file, std::span<const std::byte> bytes, OutputLink link) {
    Result<PendingFile> pending = PendingFile::create(file, link);
    if (!pending) return pending;
    LC_TRY(opened, FileBytes::openForUpdate(pending->temporary(), file));
    LC_CHECK(opened->writeAt(0, bytes));
    LC_CHECK(opened->sync());
    pending->isSynced_ = true;
    return pending;
}

Result<void> writeWholeFile(const std::filesystem::path& file, std::span<const std::byte> bytes, OutputLink link) {
    LC_TRY(pending, prepareWholeFile(file, bytes, link));
    return pending->commit();
}

}  // namespace lightcook::formats
