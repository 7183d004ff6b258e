// Names the kinds of files that are no regular files: folders, devices, FIFOs and sockets.
#pragma once

#include <filesystem>
#include <optional>
#include <string_view>
#include <system_error>

namespace lightcook::formats {

/// Returns what a path names instead of a regular file: "a folder", "no such file", ...; nothing if it names one.
inline std::optional<std::string_view> whyNoFile(const std::filesystem::path& file) {
    std::error_code code;
    switch (std::filesystem::status(file, code).type()) {
        case std::filesystem::file_type::regular:
            return std::nullopt;
        case std::filesystem::file_type::none:
        case std::filesystem::file_type::not_found:
            return "no such file";
        case std::filesystem::file_type::directory:
            return "a folder";
        case std::filesystem::file_type::fifo:
            return "a FIFO";
        default:
            return "a device or socket";
    }
}

}  // namespace lightcook::formats
