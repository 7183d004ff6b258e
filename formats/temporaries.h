// Temporary files and folders of the process, and the end of a process that a signal interrupts.
//
// An incomplete file lies under a name that begins with kTemporaryPrefix, beside its final place. Its owner holds a lock on it (flock(2),
// which ends with the process, also in another container). So a later run can tell a file that a killed process left behind from one that
// is still being written.
#pragma once

#include <filesystem>
#include <mutex>
#include <string_view>

#include "formats/error.h"

namespace lightcook::formats {

inline constexpr std::string_view kTemporaryPrefix = ".lightcook-";

/// Makes several outputs appear together: stopOutputs() waits until none exists. Used by one thread at a time.
class OutputTransaction {
public:
    /// Fails with ErrorCode::Interrupted after stopOutputs().
    static Result<OutputTransaction> begin();

private:
    explicit OutputTransaction(std::unique_lock<std::recursive_mutex> lock) : lock_(std::move(lock)) {}
    std::unique_lock<std::recursive_mutex> lock_;
};

/// Lets no output appear any more: PendingFile::commit() and OutputTransaction::begin() fail with ErrorCode::Interrupted.
void stopOutputs();
/// Removes all temporary files and folders of this process, and blocks every thread that makes or removes one. Only _exit(2) may follow.
void abandonTemporaries();
/// Removes the temporary files and folders that killed processes left in a folder: those of this user that no process has locked. On a
/// network file system, where a lock may be unknown to other machines, only those that have not changed for a day.
void removeLeftovers(const std::filesystem::path& folder);

}  // namespace lightcook::formats
