#include "formats/temporary_folder.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>

namespace lightcook::formats {
namespace {

void removeEmpty(const std::vector<std::filesystem::path>& folders) {
    std::error_code ignored;
    for (const std::filesystem::path& folder : folders)
        if (std::filesystem::is_empty(folder, ignored)) std::filesystem::remove(folder, ignored);
}

}  // namespace

Result<TemporaryFolder> TemporaryFolder::create(const std::filesystem::path& parent) {
    std::vector<std::filesystem::path> missing;
    std::error_code code;
    for (std::filesystem::path each = parent; !each.empty() && !std::filesystem::exists(each, code); each = each.parent_path())
        missing.push_back(each);
    std::string pattern = (parent / ".lightcook-XXXXXX").string();
    std::string reason;
    code.clear();
    std::filesystem::create_directories(parent, code);
    if (code) {
        reason = code.message();
    } else if (::mkdtemp(pattern.data()) == nullptr) {
        reason = std::strerror(errno);
    } else {
        return TemporaryFolder(pattern, std::move(missing));
    }
    removeEmpty(missing);
    return failure(ErrorCode::Internal, parent.string(), fmt::format("cannot make a temporary folder in it: {}", reason));
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

TemporaryFolder::TemporaryFolder(std::filesystem::path path, std::vector<std::filesystem::path> madeParents)
    : path_(std::move(path)), madeParents_(std::move(madeParents)) {}

TemporaryFolder::TemporaryFolder(TemporaryFolder&& other) noexcept
    : path_(std::exchange(other.path_, {})), madeParents_(std::exchange(other.madeParents_, {})) {}

TemporaryFolder& TemporaryFolder::operator=(TemporaryFolder&& other) noexcept {
    std::swap(path_, other.path_);
    std::swap(madeParents_, other.madeParents_);
    return *this;
}

TemporaryFolder::~TemporaryFolder() {
    std::error_code ignored;
    if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
    removeEmpty(madeParents_);
}

}  // namespace lightcook::formats
