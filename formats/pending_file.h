// A file that appears under its name whole or not at all: written beside its place, synced, renamed.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "formats/error.h"

namespace lightcook::formats {

/// Owns the temporary name until commit(); without it the temporary file is removed when this goes.
class PendingFile {
public:
    /// Creates an empty file beside `file`, in the same folder (a rename must not cross file systems), with a name nobody else has.
    static Result<PendingFile> create(const std::filesystem::path& file);
    PendingFile(PendingFile&& other) noexcept;
    PendingFile& operator=(PendingFile&& other) noexcept;
    ~PendingFile();

    const std::filesystem::path& target() const { return target_; }
    const std::filesystem::path& temporary() const { return temporary_; }

    /// Syncs what has been written to temporary() and renames it to target(). Every stream on it is closed before this.
    Result<void> commit();

private:
    PendingFile(std::filesystem::path target, std::filesystem::path temporary);
    std::filesystem::path target_, temporary_;  ///< temporary_ is empty once committed or moved from
};

/// The same for bytes that are in memory already.
Result<void> writeWholeFile(const std::filesystem::path& file, std::span<const std::byte> bytes);

}  // namespace lightcook::formats
