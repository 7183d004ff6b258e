#include "pipeline/graph/files.h"

#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <system_error>

#include "formats/read_file.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;
using formats::failure;
using formats::Result;

tl::unexpected<formats::Error> systemFailure(const std::filesystem::path& file, const char* what) {
    return failure(ErrorCode::Internal, file, fmt::format("found '{}', expected to {}", std::strerror(errno), what));
}

}  // namespace

Result<void> makeFolder(const std::filesystem::path& folder) {
    std::error_code code;
    if (!folder.empty()) std::filesystem::create_directories(folder, code);
    if (code) {
        const bool isMistake = code == std::errc::filename_too_long;
        return failure(isMistake ? ErrorCode::InvalidRequest : ErrorCode::Internal, folder,
                       fmt::format("found '{}', expected to make this folder", code.message()));
    }
    return {};
}

Result<void> makeFoldersOf(const std::filesystem::path& folder, const std::filesystem::path& name) {
    std::filesystem::path place = folder;
    for (const std::filesystem::path& part : name.parent_path()) {
        place /= part;
        std::error_code code;
        if (std::filesystem::is_symlink(place, code) && !std::filesystem::remove(place, code))
            return failure(ErrorCode::Internal, place, fmt::format("found '{}', expected to replace this link", code.message()));
    }
    return makeFolder(place);
}

std::optional<std::filesystem::path> inPlaceOfFolder(const std::filesystem::path& folder, const std::filesystem::path& name) {
    std::filesystem::path place = folder;
    for (const std::filesystem::path& part : name.parent_path()) {
        place /= part;
        std::error_code code;
        const std::filesystem::file_status status = std::filesystem::symlink_status(place, code);
        if (std::filesystem::exists(status) && !std::filesystem::is_directory(status)) return place;
    }
    return std::nullopt;
}

void removeFileOf(const std::filesystem::path& folder, const std::filesystem::path& name) {
    std::error_code ignored;
    if (!inPlaceOfFolder(folder, name)) std::filesystem::remove(folder / name, ignored);
}

void removeEmptyFoldersOf(const std::filesystem::path& folder, const std::filesystem::path& name) {
    if (inPlaceOfFolder(folder, name)) return;  // a link is no folder of ours
    std::error_code ignored;
    std::filesystem::path part = name.parent_path();
    while (!part.empty() && std::filesystem::remove(folder / part, ignored)) part = part.parent_path();
}

const std::filesystem::path& StagedFolder::of(const std::filesystem::path& name) const {
    std::error_code code;
    return !staging.empty() && std::filesystem::exists(staging / name, code) ? staging : folder;
}

Result<void> writeFile(const std::filesystem::path& file, std::span<const std::byte> content, OutputLink link) {
    LC_CHECK(makeFolder(file.parent_path()));
    return formats::writeWholeFile(file, content, link);
}

Result<void> writeFile(const std::filesystem::path& file, std::string_view content, OutputLink link) {
    return writeFile(file, std::as_bytes(std::span(content.data(), content.size())), link);
}

Result<std::string> readFile(const std::filesystem::path& file) {
    return formats::readWholeText(file);
}

Result<std::optional<formats::PendingFile>> prepareFileIfChanged(const std::filesystem::path& file, std::string_view content) {
    std::error_code code;
    if (std::filesystem::file_size(file, code) == content.size() && !code) {
        const auto present = readFile(file);
        if (present && *present == content) return std::nullopt;
    }
    LC_CHECK(makeFolder(file.parent_path()));
    return formats::prepareWholeFile(file, std::as_bytes(std::span(content)), OutputLink::Replace);
}

std::uint64_t sizeOf(const std::filesystem::path& file) {
    std::error_code code;
    const std::uintmax_t size = std::filesystem::file_size(file, code);
    return code ? 0 : size;
}

Result<void> copyFile(const std::filesystem::path& source, const std::filesystem::path& destination, OutputLink link) {
    LC_CHECK(makeFolder(destination.parent_path()));
    LC_TRY(pending, formats::PendingFile::create(destination, link));
    LC_CHECK(pending->copyFrom(source));
    return pending->commit();
}

Result<void> moveFile(const std::filesystem::path& source, const std::filesystem::path& destination) {
    LC_TRY(place, formats::findOutputPlace(destination, OutputLink::Replace));
    if (!place->isStream) {
        if (::rename(source.c_str(), place->path.c_str()) == 0) return {};
        if (errno != EXDEV) return systemFailure(destination, "move a finished file here");
    }
    LC_CHECK(copyFile(source, destination));
    std::error_code ignored;
    std::filesystem::remove(source, ignored);
    return {};
}

}  // namespace lightcook::pipeline
