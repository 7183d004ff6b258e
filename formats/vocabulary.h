// Tables of names: every closed set of names that users meet (pixel formats, layouts, targets, conventions) is one constexpr array of
// rows, in the order of its enumeration. Parsing, help texts, error messages and documents are derived from the rows.
//
//   enum class Fruit { Apple, Pear };
//   struct FruitInfo { Fruit id; std::string_view name; ... };
//   constexpr std::array kFruits = {FruitInfo{Fruit::Apple, "apple"}, FruitInfo{Fruit::Pear, "pear"}};
//   static_assert(isCompleteTable(kFruits, Fruit::Pear));
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace lightcook::formats {

/// Returns true if row i of a table has the i-th enumerator as its id, up to and including `last`, and no two rows share a name.
template <class Table, class Enum>
constexpr bool isCompleteTable(const Table& table, Enum last) {
    for (std::size_t i = 0; i < table.size(); ++i) {
        if (static_cast<std::size_t>(table[i].id) != i || table[i].name.empty()) return false;
        for (std::size_t j = 0; j < i; ++j)
            if (table[j].name == table[i].name) return false;
    }
    return table.size() == static_cast<std::size_t>(last) + 1;
}

/// Returns the row of a name, or null for a name that the table does not have.
template <class Row>
constexpr const Row* findByName(std::span<const Row> table, std::string_view name) {
    for (const Row& row : table)
        if (row.name == name) return &row;
    return nullptr;
}

/// Returns the names of all rows, in the order of the table.
template <class Row>
std::vector<std::string> namesOf(std::span<const Row> table) {
    std::vector<std::string> names;
    for (const Row& row : table) names.emplace_back(row.name);
    return names;
}

/// Returns "bc, astc or float": the names of all rows, for messages and help texts.
template <class Row>
std::string listOfNames(std::span<const Row> table) {
    std::string text;
    for (std::size_t i = 0; i < table.size(); ++i) {
        if (i > 0) text += i + 1 == table.size() ? " or " : ", ";
        text += table[i].name;
    }
    return text;
}

}  // namespace lightcook::formats
