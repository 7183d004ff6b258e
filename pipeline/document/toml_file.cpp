#include "pipeline/document/toml_file.h"

#include <algorithm>
#include <cctype>

#include "formats/read_file.h"

namespace lightcook::pipeline {
namespace {

/// toml++ limits the depth of values to 256, but not that of dotted keys, and its destructors recurse: 40,000 parts end the process.
constexpr int kMostKeyParts = 64;

/// Returns the line of a key of more parts; 0: none. A text of as many words with dots between them counts as well, dots in a row do not.
std::ptrdiff_t lineOfLongKey(const std::string& toml) {
    int dots = 0;
    for (std::size_t at = 0; at < toml.size(); ++at) {
        const char c = toml[at];
        if (c == '.' && at > 0 && toml[at - 1] != '.') {
            if (++dots >= kMostKeyParts) return std::count(toml.begin(), toml.begin() + static_cast<std::ptrdiff_t>(at), '\n') + 1;
        } else if (std::isalnum(static_cast<unsigned char>(c)) == 0 && std::string_view("_-\"' \t").find(c) == std::string_view::npos) {
            dots = 0;
        }
    }
    return 0;
}

}  // namespace

std::string hintOfSyntax(const toml::parse_error& mistake) {
    const bool isOfEscape = mistake.description().find("escape sequence") != std::string_view::npos;
    return isOfEscape ? ": '\\' begins an escape in \"...\"; write '/' between the folders of a path" : "";
}

formats::Result<std::string> readTomlText(const std::filesystem::path& file, std::uint64_t mostBytes, const char* expected) {
    const auto text = formats::readWholeText(file, mostBytes);
    if (!text) return formats::failure(formats::ErrorCode::InvalidRequest, file, text.error().detail);
    if (const auto line = lineOfLongKey(*text); line != 0)
        return formats::failure(formats::ErrorCode::InvalidRequest, formats::Subject::inLine(file, static_cast<int>(line)),
                                fmt::format("found a key of more than {} parts, expected {}", kMostKeyParts, expected));
    return *text;
}

}  // namespace lightcook::pipeline
