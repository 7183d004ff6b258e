// Temporary files and folders of the process, and the end of a process that a signal interrupts.
//
// An incomplete file lies under a name that begins with kTemporaryPrefix, beside its final place. It is removed with its owner, or by
// abandonTemporaries() at a signal. A process that was killed leaves it.
#pragma once

#include <filesystem>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "formats/error.h"

namespace lightcook::formats {

inline constexpr std::string_view kTemporaryPrefix = ".lightcook-";

/// Owns a temporary file or folder, which its destructor removes.
class Temporary {
public:
    /// Makes an empty file. The extension stays last: image libraries choose the format by it.
    static Result<Temporary> makeFile(const std::filesystem::path& folder, const std::filesystem::path& extension);
    /// Makes a folder, and missing parents too; they are removed again with the folder if they are empty then.
    static Result<Temporary> makeFolder(const std::filesystem::path& parent);
    Temporary(Temporary&& other) noexcept { *this = std::move(other); }
    Temporary& operator=(Temporary&& other) noexcept;
    ~Temporary();

    const std::filesystem::path& path() const { return path_; }
    /// Renames the file, which ends the ownership. Fails with ErrorCode::Interrupted after stopOutputs().
    Result<void> renameTo(const std::filesystem::path& file);

private:
    Temporary() = default;
    using Make = bool (*)(const char* path);
    /// made   with the parents that were made for it
    static Result<Temporary> make(Temporary made, const std::filesystem::path& folder, const std::string& ending, Make make,
                                  const char* step);
    std::filesystem::path path_;                      ///< empty once renamed or moved from
    std::vector<std::filesystem::path> madeParents_;  ///< the deepest first
};

/// Makes several outputs appear together: stopOutputs() waits until none exists.
class OutputTransaction {
public:
    /// Fails with ErrorCode::Interrupted after stopOutputs().
    static Result<OutputTransaction> begin();

private:
    explicit OutputTransaction(std::unique_lock<std::mutex> lock) : lock_(std::move(lock)) {}
    std::unique_lock<std::mutex> lock_;
};

/// Lets no output appear any more: PendingFile::commit() and OutputTransaction::begin() fail with ErrorCode::Interrupted. Waits a second at
/// most for those that are just appearing together.
void stopOutputs();
/// Returns true after stopOutputs().
bool areOutputsStopped();
/// Removes all temporary files and folders of this process, and blocks every thread that makes or removes one. Only _exit(2) may follow.
/// Allocates nothing. Gives up after a second if a thread that ends the process is just making or removing one.
void abandonTemporaries();
/// Removes the temporary files and folders in a folder that have not changed for a day: those of killed processes.
void removeOldTemporaries(const std::filesystem::path& folder);

/// Returns the error of a system call on a file that is written, with what to do. A name that no file can have is a mistake of the request.
tl::unexpected<Error> outputFailure(const std::filesystem::path& file, const char* step, int errorNumber);

}  // namespace lightcook::formats
