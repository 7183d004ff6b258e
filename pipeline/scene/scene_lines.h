// Lines of the tables and keys of a scene file, so that a finding of a later step can point into it.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <string_view>

namespace lightcook::pipeline {

class SceneLines {
public:
    /// Records a table, or a key of it.
    /// section  "output", "light_map"; empty for the keys before the first table
    /// name     of an element of an array of tables ("lobby"), else empty
    /// key      empty for the table itself
    void add(std::string_view section, std::string_view name, std::string_view key, int line);

    /// Records a key that names a file. Of several the first one counts.
    void add(const std::filesystem::path& file, int line) { linesOfFiles_.emplace(file.lexically_normal(), line); }

    /// Returns the line of the key, from 1; without such a key that of its table; nothing without such a table.
    std::optional<int> find(std::string_view section, std::string_view name = "", std::string_view key = "") const;
    /// Returns the line that names a file.
    std::optional<int> findFile(const std::filesystem::path& file) const;

private:
    std::map<std::string, int, std::less<>> lines_;  ///< by "section/name/key"
    std::map<std::filesystem::path, int> linesOfFiles_;
};

}  // namespace lightcook::pipeline
