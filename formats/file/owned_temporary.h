// A temporary file or folder: locked while its owner lives, known to abandonTemporaries(), removed with its owner.
#pragma once

#include <filesystem>
#include <memory>
#include <vector>

#include "formats/error.h"

namespace lightcook::formats {

class OwnedTemporary {
public:
    /// Makes an empty file. The extension stays last: image libraries choose the format by it.
    /// step  that an error names
    static Result<OwnedTemporary> makeFile(const std::filesystem::path& folder, const std::filesystem::path& extension,
                                           const char* step = "creating it");
    /// Makes missing parents too; they are removed again with the folder if they are empty then.
    static Result<OwnedTemporary> makeFolder(const std::filesystem::path& parent);
    OwnedTemporary(OwnedTemporary&& other) noexcept;
    OwnedTemporary& operator=(OwnedTemporary&& other) noexcept;
    ~OwnedTemporary();

    const std::filesystem::path& path() const { return path_; }
    /// Renames the file, which ends the ownership. Fails with ErrorCode::Interrupted after stopOutputs().
    Result<void> renameTo(const std::filesystem::path& file);

private:
    OwnedTemporary(std::filesystem::path path, int lock) : path_(std::move(path)), lock_(lock) {}
    OwnedTemporary(std::filesystem::path path, std::unique_ptr<OwnedTemporary> lockFile, std::vector<std::filesystem::path> madeParents);
    std::filesystem::path path_;                      ///< empty once renamed or moved from
    int lock_ = -1;                                   ///< of a file: descriptor that holds the lock; -1 where the file system has none
    std::unique_ptr<OwnedTemporary> lockFile_;        ///< of a folder: not every file system locks folders
    std::vector<std::filesystem::path> madeParents_;  ///< the deepest first
};

/// Returns the error of a system call on a file that is written, with what to do. A name that no file can have is a mistake of the request.
tl::unexpected<Error> outputFailure(const std::filesystem::path& file, const char* step, int errorNumber);

}  // namespace lightcook::formats
