// The scan knows only what decides the depth of TOML 1.0: comments, the four kinds of strings, brackets, dots and separators. On a text
// that is no TOML it may find any depth below the limit, and the parser then reports the syntax error.
#include "pipeline/document/toml_nesting.h"

#include <algorithm>

namespace lightcook::pipeline {
namespace {

/// Returns the index after the string that begins at `at` with a quotation mark.
std::size_t endOfString(std::string_view text, std::size_t at) {
    const char quote = text[at];
    const bool isMultiLine = text.substr(at, 3) == std::string_view(quote == '"' ? "\"\"\"" : "'''");
    for (std::size_t i = at + (isMultiLine ? 3 : 1); i < text.size(); ++i) {
        if (quote == '"' && text[i] == '\\') {
            ++i;
        } else if (!isMultiLine && text[i] == '\n') {
            return i;  // not closed
        } else if (text[i] == quote && (!isMultiLine || text.substr(i, 3) == std::string_view(quote == '"' ? "\"\"\"" : "'''"))) {
            return i + (isMultiLine ? 3 : 1);
        }
    }
    return text.size();
}

TomlPlace placeOf(std::string_view text, std::size_t at) {
    const std::string_view before = text.substr(0, at);
    const std::size_t lineStart = before.rfind('\n') == std::string_view::npos ? 0 : before.rfind('\n') + 1;
    return {static_cast<int>(std::count(before.begin(), before.end(), '\n')) + 1, static_cast<int>(at - lineStart) + 1};
}

}  // namespace

std::optional<TomlPlace> placeNestedDeeper(std::string_view toml, int most) {
    int depth = 0, dots = 0;
    for (std::size_t at = 0; at < toml.size();) {
        const char c = toml[at];
        if (c == '"' || c == '\'') {
            at = endOfString(toml, at);
            continue;
        }
        if (c == '#') {
            at = std::min(toml.find('\n', at), toml.size());
            continue;
        }
        if (c == '[' || c == '{') ++depth;
        if ((c == ']' || c == '}') && depth > 0) --depth;
        if (std::string_view("=,[]{}\n").find(c) != std::string_view::npos) dots = 0;
        if (c == '.') ++dots;
        if (depth > most || dots >= most) return placeOf(toml, at);
        ++at;
    }
    return std::nullopt;
}

}  // namespace lightcook::pipeline
