// A file that gets its name only when it is complete: written beside its place, synced, renamed. A symbolic link that the user names stays,
// and the file that it names is replaced. A link inside an output folder is replaced itself, so that no file outside changes. What is no
// regular file, such as a device, stays too, and the complete content is written into it.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "formats/error.h"
#include "formats/temporaries.h"

namespace lightcook::formats {

/// The place that an output path means.
struct OutputPlace {
    std::filesystem::path path;  ///< no symbolic link, except for a stream (/dev/stdout)
    bool isStream = false;       ///< a device or pipe: to be written into, not to be replaced
};
/// If a symbolic link has the name of an output, the write follows or replaces it.
enum class OutputLink {
    Follow,   ///< it stays, and the file that it names is replaced: for files that the user names
    Replace,  ///< the output takes its place, and the file that it names stays: for files of an output folder
};
/// Fails if the path names a folder, or cannot be a file's.
Result<OutputPlace> findOutputPlace(const std::filesystem::path& file, OutputLink link = OutputLink::Follow);

/// Owns the temporary file. The destructor removes it unless commit() was called.
class PendingFile {
public:
    /// Creates an empty file with a unique name in the folder of the file that `file` means (a rename must not cross file systems).
    static Result<PendingFile> create(const std::filesystem::path& file, OutputLink link = OutputLink::Follow);

    const std::filesystem::path& target() const { return target_; }
    const std::filesystem::path& temporary() const { return temporary_.path(); }

    /// Copies the content of a file into temporary(), which is empty.
    Result<void> copyFrom(const std::filesystem::path& source) const;
    /// Syncs the file temporary() and renames it to target(), or writes it into the stream. Close every stream on it first. Fails with
    /// ErrorCode::Interrupted after stopOutputs().
    Result<void> commit();

private:
    PendingFile(std::filesystem::path target, OutputPlace place, Temporary temporary)
        : target_(std::move(target)), place_(std::move(place)), temporary_(std::move(temporary)) {}
    std::filesystem::path target_;  ///< as the caller names it, for messages
    OutputPlace place_;
    Temporary temporary_;
    bool isSynced_ = false;

    friend Result<PendingFile> prepareWholeFile(const std::filesystem::path& file, std::span<const std::byte> bytes, OutputLink link);
};

/// Writes and syncs bytes into such a file, whose commit() then only renames it: for files that appear together.
Result<PendingFile> prepareWholeFile(const std::filesystem::path& file, std::span<const std::byte> bytes,
                                     OutputLink link = OutputLink::Follow);
/// Writes bytes to a file in the same way.
Result<void> writeWholeFile(const std::filesystem::path& file, std::span<const std::byte> bytes, OutputLink link = OutputLink::Follow);

}  // namespace lightcook::formats
