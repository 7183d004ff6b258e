// A folder that is removed with everything in it when its owner goes out of scope. The program, the benches and the tests use this one.
#pragma once

#include <filesystem>
#include <vector>

#include "formats/error.h"

namespace lightcook::formats {

class TemporaryFolder {
public:
    /// Makes a folder inside `parent`. Missing parents are made too; they are removed again with this folder if they are empty then.
    static Result<TemporaryFolder> create(const std::filesystem::path& parent);
    /// Makes a folder where the system keeps temporary files (TMPDIR).
    static Result<TemporaryFolder> create();
    /// Does the same for programs that stop at the first error: throws std::runtime_error where create() returns one.
    TemporaryFolder();
    TemporaryFolder(TemporaryFolder&& other) noexcept;
    TemporaryFolder& operator=(TemporaryFolder&& other) noexcept;
    ~TemporaryFolder();

    const std::filesystem::path& path() const { return path_; }
    std::filesystem::path operator/(const std::filesystem::path& name) const { return path_ / name; }

private:
    TemporaryFolder(std::filesystem::path path, std::vector<std::filesystem::path> madeParents);
    std::filesystem::path path_;                      ///< empty once moved from
    std::vector<std::filesystem::path> madeParents_;  ///< the deepest first
};

}  // namespace lightcook::formats
