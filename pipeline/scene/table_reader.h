// Reads the keys of one table of a scene file. The first mistake of a table is thrown, with its line and column; readScene returns it as an
// error.
#pragma once

#include <fmt/format.h>

#include <toml++/toml.h>
#include <filesystem>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "formats/error.h"
#include "formats/vocabulary.h"
#include "pipeline/document/toml_file.h"
#include "pipeline/scene/checks.h"
#include "pipeline/scene/keys.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

/// Returns a text as messages quote it.
std::string inQuotes(std::string_view text);
/// Returns names as messages list them.
std::string listed(const std::vector<std::string>& names);

/// Reads the keys of one table of the file. The constructor refuses keys that the section does not have (keys.h).
class TableReader {
public:
    /// `section`: a name of keys.h; empty for the keys before the first table.
    TableReader(const toml::table& table, std::filesystem::path file, std::string_view section);

    [[noreturn]] void fail(const toml::node& node, const std::string& detail) const;

    /// Refuses the value of a key that a check objects to.
    void check(const char* key, const Objection& objection) const;

    /// Reads the name of a row of a table.
    template <class Row>
    auto oneOfRows(const char* key, std::span<const Row> rows) {
        const Row* row = formats::findByName(rows, oneOf(key, formats::namesOf(rows), std::string(rows.front().name)));
        if (row == nullptr) throw std::logic_error(fmt::format("the key '{}' has a name without a row", key));
        return row->id;
    }

    bool has(const char* key) const { return table_.contains(key); }
    bool isString(const char* key) const { return table_[key].is_string(); }

    template <class T>
    std::optional<T> optional(const char* key, const char* expected) {
        requireRow(key);
        const toml::node* node = table_.get(key);
        if (node == nullptr) return std::nullopt;
        std::optional<T> value;
        if constexpr (std::is_same_v<T, bool>)
            value = node->value_exact<bool>();  // numbers are none
        else if (!node->is_boolean())           // toml++ converts true to 1
            value = node->value<T>();
        if (!value) failType(*node, key, expected);
        return value;
    }

    template <class T>
    T required(const char* key, const char* expected) {
        const std::optional<T> value = optional<T>(key, expected);
        if (!value) fail(table_, fmt::format("found no key '{}' in {}, expected {}", key, name_, expected));
        return *value;
    }

    /// Reads a fraction: a number, or a string such as "2%".
    std::optional<double> fraction(const char* key, const char* expected);
    /// Reads an integer from 1 to `most`.
    std::optional<int> positiveInteger(const char* key, std::int64_t most);
    /// Reads one of some names. Without the key returns `otherwise`.
    std::string oneOf(const char* key, const std::vector<std::string>& choices, const std::string& otherwise);

    /// Returns the path relative to the scene file's folder.
    std::filesystem::path resolve(const std::string& text) const { return (file_.parent_path() / text).lexically_normal(); }
    std::filesystem::path requiredPath(const char* key) { return pathOf(key, required<std::string>(key, "a path")); }
    std::optional<std::filesystem::path> optionalPath(const char* key);
    /// Refuses a path with a character 0: the system would open the file of the part before it.
    void checkPath(const toml::node& node, std::string_view key, const std::string& text) const;

    /// Returns nullptr if the key is missing.
    const toml::array* array(const char* key, const char* expected);
    std::optional<std::vector<double>> numbers(const char* key, const char* expected);
    std::optional<Range> range(const char* key, double lowest, double highest);

    /// Returns the table [key], or nullptr without one.
    const toml::table* table(const char* key);
    /// Returns the table that a key holds.
    const toml::table& requiredTable(const char* key, const char* expected);
    /// Returns the tables [[key]].
    std::vector<const toml::table*> tables(const char* key);

    const toml::node& node(const char* key) const { return *table_.get(key); }
    /// Returns file, line and column of the value of a key.
    std::string place(const char* key) const;

private:
    void refuseUnknownKeys() const;
    /// Throws if a key that is read has no row in keys.h.
    void requireRow(std::string_view key) const;
    std::filesystem::path pathOf(const char* key, const std::string& text);
    [[noreturn]] void failType(const toml::node& node, const char* key, std::string_view expected) const;

    const toml::table& table_;
    std::filesystem::path file_;
    std::string name_;  ///< for messages
    const SceneSectionInfo& section_;
};

}  // namespace lightcook::pipeline
