// Text as a word of a shell's command line.
#pragma once

#include <string>
#include <string_view>

namespace lightcook::pipeline {

/// Returns the text in single quotes of sh, bash and zsh.
inline std::string shellQuoted(const std::string& text) {
    std::string result = "'";
    for (const char c : text) result += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return result + "'";
}

/// Returns the text as one word of a command line: in quotes unless every shell takes it as it is.
inline std::string shellWord(const std::string& text) {
    constexpr std::string_view kPlain = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+.,:/@";
    return text.empty() || text.find_first_not_of(kPlain) != std::string::npos ? shellQuoted(text) : text;
}

}  // namespace lightcook::pipeline
