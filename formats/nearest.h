// Finds the known name nearest to a mistyped one, for error messages. Names that the found one is a part of ("bc6" of "bc6h-uf16") are
// nearest, the others follow by their edit distance.
#pragma once

#include <algorithm>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace lightcook::formats {

/// Returns the Levenshtein distance: the number of insertions, deletions and substitutions of one character.
inline std::size_t editDistance(std::string_view a, std::string_view b) {
    std::vector<std::size_t> row(b.size() + 1);
    for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i) {
        std::size_t diagonal = row[0];
        row[0] = i;
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t substituted = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
            diagonal = row[j];
            row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
        }
    }
    return row[b.size()];
}

/// Returns true if `part` is in `name`, and is long enough for that to be no accident.
inline bool isPartOfName(std::string_view part, std::string_view name) {
    constexpr std::size_t kLeastLetters = 3;
    return part.size() >= kLeastLetters && name.find(part) != std::string_view::npos;
}

/// Returns the first of the nearest names; empty if `known` is empty.
inline std::string nearestName(std::string_view found, std::span<const std::string> known) {
    const auto rank = [&](const std::string& name) { return std::pair(!isPartOfName(found, name), editDistance(found, name)); };
    const auto nearest = std::ranges::min_element(known, {}, rank);
    return nearest == known.end() ? std::string() : *nearest;
}

/// Returns "; nearest is 'x'" for the end of a message; empty if no name is near: a third of the letters may differ, or one name is a part
/// of the other.
inline std::string nearestHint(std::string_view found, std::span<const std::string> known) {
    const std::string nearest = nearestName(found, known);
    const bool isNear =
        isPartOfName(found, nearest) || isPartOfName(nearest, found) || editDistance(found, nearest) <= 1 + found.size() / 3;
    return nearest.empty() || !isNear ? "" : "; nearest is '" + nearest + "'";
}

}  // namespace lightcook::formats
