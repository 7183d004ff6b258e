#include "formats/read_file.h"

#include <fmt/format.h>

#include <span>

#include "formats/file/file_bytes.h"
#include "formats/memory.h"

namespace lightcook::formats {

Result<std::vector<std::byte>> readWholeFile(const std::filesystem::path& file) {
    const auto opened = FileBytes::openForReading(file);
    if (!opened) return tl::make_unexpected(opened.error());
    if (const auto fits = checkMemory(opened->size(), file.string()); !fits) return tl::make_unexpected(fits.error());
    std::vector<std::byte> bytes(opened->size());
    if (const auto read = opened->readAt(0, bytes); !read) return tl::make_unexpected(read.error());
    return bytes;
}

Result<std::string> readWholeText(const std::filesystem::path& file, std::uint64_t mostBytes) {
    const auto opened = FileBytes::openForReading(file);
    if (!opened) return tl::make_unexpected(opened.error());
    if (opened->size() > mostBytes)
        return failure(ErrorCode::FileUnreadable, file.string(),
                       fmt::format("found {} bytes, expected at most {}", opened->size(), mostBytes));
    std::string text(opened->size(), '\0');
    if (const auto read = opened->readAt(0, std::as_writable_bytes(std::span(text))); !read) return tl::make_unexpected(read.error());
    return text;
}

}  // namespace lightcook::formats
