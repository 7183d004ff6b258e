// Depth of nesting of a JSON text, found before it is parsed: parsers and destructors recurse or take quadratic time on hostile ones.
#pragma once

#include <string_view>

namespace lightcook::formats {

/// Returns true if brackets and braces outside strings are nested deeper than `most`.
inline bool isNestedDeeper(std::string_view json, int most) {
    int depth = 0;
    bool isInString = false;
    for (std::size_t at = 0; at < json.size(); ++at) {
        const char c = json[at];
        if (isInString) {
            if (c == '\\') ++at;
            if (c == '"') isInString = false;
        } else if (c == '"') {
            isInString = true;
        } else if (c == '[' || c == '{') {
            if (++depth > most) return true;
        } else if (c == ']' || c == '}') {
            --depth;
        }
    }
    return false;
}

}  // namespace lightcook::formats
