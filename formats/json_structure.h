// Limits on the structure of a JSON text, checked before it is parsed: destructors and writers recurse as deep as it goes, and an object
// that keeps the order of its members takes a time that is quadratic in their number (100,000 of them: 10 s).
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace lightcook::formats {

inline constexpr int kMostJsonMembers = 2000;  ///< of one object; ours and those of glTF have a few dozen

/// Describes the fault of a text whose brackets and braces outside strings are nested deeper than `mostDeep`, or that has an object with
/// more than kMostJsonMembers members. Returns nothing for a text that can be parsed.
inline std::optional<std::string> faultOfStructure(std::string_view json, std::size_t mostDeep) {
    std::vector<int> commas;  // so far, of each object that is open; -1 for an array
    bool isInString = false;
    for (std::size_t at = 0; at < json.size(); ++at) {
        const char c = json[at];
        if (isInString) {
            if (c == '\\') ++at;
            if (c == '"') isInString = false;
        } else if (c == '"') {
            isInString = true;
        } else if (c == '[' || c == '{') {
            commas.push_back(c == '{' ? 0 : -1);
            if (commas.size() > mostDeep) return std::string("JSON nested more than ").append(std::to_string(mostDeep)).append(" deep");
        } else if ((c == ']' || c == '}') && !commas.empty()) {
            commas.pop_back();
        } else if (c == ',' && !commas.empty() && commas.back() >= 0 && ++commas.back() >= kMostJsonMembers) {
            return std::string("a JSON object of more than ").append(std::to_string(kMostJsonMembers)).append(" members");
        }
    }
    return std::nullopt;
}

}  // namespace lightcook::formats
