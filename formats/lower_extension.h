// The extension by which files are told apart, whatever its case.
#pragma once

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <string>

namespace lightcook::formats {

/// Returns the extension in lower case: ".ktx2".
inline std::string lowerExtension(const std::filesystem::path& file) {
    std::string extension = file.extension().string();
    std::ranges::transform(extension, extension.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return extension;
}

}  // namespace lightcook::formats
