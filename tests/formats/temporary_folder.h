// Whole files as strings, for tests that work in a TemporaryFolder.
#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "formats/temporary_folder.h"

namespace lightcook::formats {

inline std::string contentOf(const std::filesystem::path& file) {
    std::ostringstream content;
    content << std::ifstream(file, std::ios::binary).rdbuf();
    return content.str();
}

inline void writeContent(const std::filesystem::path& file, const std::string& content) {
    std::ofstream(file, std::ios::binary).write(content.data(), static_cast<std::streamsize>(content.size()));
}

/// Overwrites one byte in place: thousands of broken copies of a file cost nothing this way.
inline void setByte(const std::filesystem::path& file, std::size_t at, char byte) {
    std::fstream stream(file, std::ios::binary | std::ios::in | std::ios::out);
    stream.seekp(static_cast<std::streamoff>(at));
    stream.put(byte);
}

}  // namespace lightcook::formats
