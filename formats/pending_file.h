// A file that gets its name only when it is complete: written beside its place, synced, renamed.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "formats/error.h"

namespace lightcook::formats {

/// Owns the temporary file. The destructor removes it unless commit() was called.
class PendingFile {
public:
    /// Creates an empty file with a unique name in the folder of `file` (a rename must not cross file systems).
    static Result<PendingFile> create(const std::filesystem::path& file);
    PendingFile(PendingFile&& other) noexcept;
    PendingFile& operator=(PendingFile&& other) noexcept;
    ~PendingFile();

    const std::filesystem::path& target() const { return target_; }
    const std::filesystem::path& temporary() const { return temporary_; }

    /// Syncs the file temporary() and renames it to target(). Close every stream on it first.
    Result<void> commit();

private:
    PendingFile(std::filesystem::path target, std::filesystem::path temporary);
    std::filesystem::path target_, temporary_;  ///< temporary_ is empty once committed or moved from
};

/// Writes bytes to a file in the same way.
Result<void> writeWholeFile(const std::filesystem::path& file, std::span<const std::byte> bytes);

}  // namespace lightcook::formats
