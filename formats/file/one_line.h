// Error strings of libraries, shortened for one-line messages.
#pragma once

#include <algorithm>
#include <string>
#include <string_view>

namespace lightcook::formats {

/// Replaces runs of white space and control characters by one space and cuts the text at 240 characters.
inline std::string oneLine(std::string_view text) {
    constexpr std::size_t kLongest = 240;
    std::string line;
    for (const char character : text) {
        const bool isBlank = static_cast<unsigned char>(character) <= ' ' || character == '\x7f';
        if (!isBlank) {
            line += character;
        } else if (!line.empty() && line.back() != ' ') {
            line += ' ';
        }
        if (line.size() == kLongest) return line + "...";
    }
    while (!line.empty() && (line.back() == ' ' || line.back() == '.')) line.pop_back();
    return line;
}

/// Returns such a line in quotes. Quotes in it become single ones.
inline std::string quotedLine(std::string_view text) {
    std::string line = oneLine(text);
    std::ranges::replace(line, '"', '\'');
    return '"' + line + '"';
}

}  // namespace lightcook::formats
