// Finds the known name nearest to a mistyped one, for error messages.
#pragma once

#include <algorithm>
#include <span>
#include <string>
#include <string_view>
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

/// Returns the first of the nearest names; empty if `known` is empty.
inline std::string nearestName(std::string_view found, std::span<const std::string> known) {
    std::string nearest;
    std::size_t least = 0;
    for (const std::string& name : known) {
        const std::size_t distance = editDistance(found, name);
        if (nearest.empty() || distance < least) {
            nearest = name;
            least = distance;
        }
    }
    return nearest;
}

}  // namespace lightcook::formats
