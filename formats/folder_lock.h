// A lock on a folder that a process writes a set of files into. It is a lock of the folder itself (flock(2)), so that no file appears in or
// beside it, and ends with the process, also with one that is killed.
#pragma once

#include <filesystem>
#include <optional>

#include "formats/error.h"

namespace lightcook::formats {

class FolderLock {
public:
    /// Locks a folder without waiting. Returns nothing if another owner holds its lock, in this process or another one. Where there is no
    /// folder, or the file system has no locks for folders, the lock is an empty one.
    static std::optional<FolderLock> take(const std::filesystem::path& folder);
    FolderLock(FolderLock&& other) noexcept;
    FolderLock& operator=(FolderLock&& other) noexcept;
    ~FolderLock();

    /// Returns true if the lock is that of the folder which the path names now. An empty lock is none.
    bool isOf(const std::filesystem::path& folder) const;

private:
    explicit FolderLock(int descriptor) : descriptor_(descriptor) {}
    int descriptor_ = -1;  ///< holds the lock; -1: an empty one
};

}  // namespace lightcook::formats
