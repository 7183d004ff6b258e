// A folder that is removed with everything in it when its owner goes out of scope. The program, the benches and the tests use this one.
#pragma once

#include <filesystem>

#include "formats/error.h"
#include "formats/temporaries.h"

namespace lightcook::formats {

class TemporaryFolder {
public:
    /// Makes a folder inside `parent`, once what killed processes left there is removed. Missing parents are made too; they are removed
    /// again with this folder if they are empty then.
    static Result<TemporaryFolder> create(const std::filesystem::path& parent);
    /// Makes a folder where the system keeps temporary files (TMPDIR).
    static Result<TemporaryFolder> create();
    /// Does the same for programs that stop at the first error: throws std::runtime_error where create() returns one.
    TemporaryFolder();

    const std::filesystem::path& path() const { return owned_.path(); }
    std::filesystem::path operator/(const std::filesystem::path& name) const { return path() / name; }

private:
    explicit TemporaryFolder(Temporary owned) : owned_(std::move(owned)) {}
    Temporary owned_;
};

/// Returns the folder where the system keeps temporary files (TMPDIR).
Result<std::filesystem::path> systemTemporaryFolder();

}  // namespace lightcook::formats
