#include "pipeline/graph/files.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>
#include <system_error>
#include <utility>

#include "formats/pending_file.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Result;

tl::unexpected<formats::Error> systemFailure(const std::filesystem::path& file, const char* what) {
    return failure(ErrorCode::Internal, file.string(), fmt::format("found '{}', expected to {}", std::strerror(errno), what));
}

}  // namespace

Result<void> makeFolder(const std::filesystem::path& folder) {
    std::error_code code;
    if (!folder.empty()) std::filesystem::create_directories(folder, code);
    if (code) return failure(ErrorCode::Internal, folder.string(), fmt::format("found '{}', expected to make this folder", code.message()));
    return {};
}

Result<void> writeFile(const std::filesystem::path& file, std::span<const std::byte> content) {
    if (auto made = makeFolder(file.parent_path()); !made) return made;
    return formats::writeWholeFile(file, content);
}

Result<void> writeFile(const std::filesystem::path& file, std::string_view content) {
    return writeFile(file, std::as_bytes(std::span(content.data(), content.size())));
}

Result<std::string> readFile(const std::filesystem::path& file) {
    std::ifstream stream(file, std::ios::binary);
    if (!stream)
        return failure(ErrorCode::FileUnreadable, file.string(), fmt::format("found '{}', expected a readable file", std::strerror(errno)));
    std::ostringstream content;
    content << stream.rdbuf();
    return std::move(content).str();
}

Result<void> writeFileIfChanged(const std::filesystem::path& file, std::string_view content) {
    std::error_code code;
    if (std::filesystem::file_size(file, code) == content.size() && !code) {
        const auto present = readFile(file);
        if (present && *present == content) return {};
    }
    return writeFile(file, content);
}

Result<void> copyFile(const std::filesystem::path& source, const std::filesystem::path& destination) {
    if (auto made = makeFolder(destination.parent_path()); !made) return made;
    auto pending = formats::PendingFile::create(destination);
    if (!pending) return tl::make_unexpected(pending.error());
    std::error_code code;
    std::filesystem::copy_file(source, pending->temporary(), std::filesystem::copy_options::overwrite_existing, code);
    if (code)
        return failure(ErrorCode::Internal, destination.string(),
                       fmt::format("found '{}', expected to copy {} here", code.message(), source.string()));
    return pending->commit();
}

Result<void> moveFile(const std::filesystem::path& source, const std::filesystem::path& destination) {
    if (::rename(source.c_str(), destination.c_str()) == 0) return {};
    if (errno != EXDEV) return systemFailure(destination, "move a finished file here");
    if (auto copied = copyFile(source, destination); !copied) return copied;
    std::error_code ignored;
    std::filesystem::remove(source, ignored);
    return {};
}

Result<TemporaryFolder> TemporaryFolder::create(const std::filesystem::path& parent) {
    std::vector<std::filesystem::path> missing;
    std::error_code code;
    for (std::filesystem::path each = parent; !each.empty() && !std::filesystem::exists(each, code); each = each.parent_path())
        missing.push_back(each);
    TemporaryFolder folder;
    folder.madeParents_ = std::move(missing);
    if (auto made = makeFolder(parent); !made) return tl::make_unexpected(made.error());
    std::string pattern = (parent / ".lightcook-XXXXXX").string();
    if (::mkdtemp(pattern.data()) == nullptr) return systemFailure(parent, "make a temporary folder in it");
    folder.path_ = pattern;
    return folder;
}

Result<TemporaryFolder> TemporaryFolder::create() {
    std::error_code code;
    const std::filesystem::path parent = std::filesystem::temp_directory_path(code);
    if (code)
        return failure(ErrorCode::Internal, "TMPDIR", fmt::format("found '{}', expected a folder for temporary files", code.message()));
    return create(parent);
}

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
    for (const std::filesystem::path& parent : madeParents_)
        if (std::filesystem::is_empty(parent, ignored)) std::filesystem::remove(parent, ignored);
}

}  // namespace lightcook::pipeline
