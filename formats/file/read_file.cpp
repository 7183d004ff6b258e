#include "formats/read_file.h"

#include <fmt/format.h>

#include <span>

#include "formats/file/file_bytes.h"
#include "formats/memory.h"

namespace lightcook::formats {

Result<std::vector<std::byte>> readWholeFile(const std::filesystem::path& file) {
    LC_TRY(opened, FileBytes::openForReading(file));
    LC_CHECK(checkMemory(opened->size(), file));
    std::vector<std::byte> bytes(opened->size());
    LC_CHECK(opened->readAt(0, bytes));
    return bytes;
}

Result<std::string> readWholeText(const std::filesystem::path& file, std::uint64_t mostBytes) {
    LC_TRY(opened, FileBytes::openForReading(file));
    if (opened->size() > mostBytes)
        return failure(ErrorCode::FileUnreadable, file, fmt::format("found {} bytes, expected at most {}", opened->size(), mostBytes));
    std::string text(opened->size(), '\0');
    LC_CHECK(opened->readAt(0, std::as_writable_bytes(std::span(text))));
    return text;
}

}  // namespace lightcook::formats
