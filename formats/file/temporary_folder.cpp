#include "formats/temporary_folder.h"

#include <fmt/format.h>

#include <stdexcept>
#include <system_error>
#include <utility>

namespace lightcook::formats {

Result<std::filesystem::path> systemTemporaryFolder() {
    std::error_code code;
    std::filesystem::path folder = std::filesystem::temp_directory_path(code);
    if (code)
        return failure(ErrorCode::Internal, "TMPDIR", fmt::format("found '{}', expected a folder for temporary files", code.message()));
    return folder;
}

Result<TemporaryFolder> TemporaryFolder::create(const std::filesystem::path& parent) {
    removeOldTemporaries(parent);
    return Temporary::makeFolder(parent).map([](Temporary&& made) { return TemporaryFolder(std::move(made)); });
}

Result<TemporaryFolder> TemporaryFolder::create() {
    return systemTemporaryFolder().and_then([](const std::filesystem::path& parent) { return create(parent); });
}

TemporaryFolder::TemporaryFolder()
    : TemporaryFolder([] {
          Result<TemporaryFolder> made = create();
          if (!made) throw std::runtime_error(made.error().line());
          return std::move(*made);
      }()) {}

}  // namespace lightcook::formats
