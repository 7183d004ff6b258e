// Whole files as strings, for tests that work in a TemporaryFolder.
#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>
#include <string>

#include "formats/temporary_folder.h"

namespace lightcook::formats {

/// Returns the content of a file; throws without it, so that two files are not equal because neither is there.
inline std::string contentOf(const std::filesystem::path& file) {
    const std::ifstream stream(file, std::ios::binary);
    if (!stream) throw std::runtime_error(file.string() + ": no such file");
    std::ostringstream content;
    content << stream.rdbuf();
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
