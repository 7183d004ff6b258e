#include "formats/temporary_folder.h"

#include <fmt/format.h>

#include <stdexcept>
#include <system_error>
#include <utility>

#include "formats/file/owned_temporary.h"
#include "formats/temporaries.h"

namespace lightcook::formats {

Result<TemporaryFolder> TemporaryFolder::create(const std::filesystem::path& parent) {
    removeLeftovers(parent);
    auto made = OwnedTemporary::makeFolder(parent);
    if (!made) return tl::make_unexpected(made.error());
    return TemporaryFolder(std::make_unique<OwnedTemporary>(std::move(*made)));
}

Result<TemporaryFolder> TemporaryFolder::create() {
    std::error_code code;
    const std::filesystem::path parent = std::filesystem::temp_directory_path(code);
    if (code)
        return failure(ErrorCode::Internal, "TMPDIR", fmt::format("found '{}', expected a folder for temporary files", code.message()));
    return create(parent);
}

TemporaryFolder::TemporaryFolder() {
    Result<TemporaryFolder> made = create();
    if (!made) throw std::runtime_error(made.error().line());
    *this = std::move(*made);
}

TemporaryFolder::TemporaryFolder(std::unique_ptr<OwnedTemporary> owned) : owned_(std::move(owned)) {}
TemporaryFolder::TemporaryFolder(TemporaryFolder&&) noexcept = default;
TemporaryFolder& TemporaryFolder::operator=(TemporaryFolder&&) noexcept = default;
TemporaryFolder::~TemporaryFolder() = default;

const std::filesystem::path& TemporaryFolder::path() const {
    return owned_->path();
}

}  // namespace lightcook::formats
