#include "pipeline/scene/table_reader.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "formats/nearest.h"
#include "pipeline/document/byte_count.h"

namespace lightcook::pipeline {

using formats::ErrorCode;

std::string inQuotes(std::string_view text) {
    return fmt::format("'{}'", text);
}

std::string listed(const std::vector<std::string>& names) {
    return fmt::format("{}", fmt::join(names, ", "));
}

namespace {

/// Returns a value as messages name it: with its type.
std::string typedValue(const toml::node& node) {
    switch (node.type()) {
        case toml::node_type::string:
            return fmt::format("the string '{}'", node.value_or(std::string()));
        case toml::node_type::integer:
            return fmt::format("the integer {}", node.value_or(std::int64_t{0}));
        case toml::node_type::floating_point:
            return fmt::format("the number {}", node.value_or(0.0));
        case toml::node_type::boolean:
            return node.value_or(false) ? "true (a boolean)" : "false (a boolean)";
        case toml::node_type::array:
            return "an array";
        case toml::node_type::table:
            return "a table";
        default:
            return "a date or time";
    }
}

/// Returns where a key belongs: "in [output] or [[light_map]]". Empty: no section has it.
std::string sectionsWith(std::string_view key) {
    std::string sections;
    for (const SceneSectionInfo& section : allSceneSections()) {
        if (formats::findByName(std::span<const SceneKeyInfo>(section.keys), key) == nullptr) continue;
        sections += sections.empty() ? "" : " or ";
        const std::string table = fmt::format("[{}]", section.name);
        sections += section.name.empty() ? "before the first table" : "in " + (section.isArray ? "[" + table + "]" : table);
    }
    return sections;
}

/// Returns the words of a mistake: a key that its table does not have.
/// table  as messages name it
/// known  keys of the table
std::string unknownKey(const std::string& key, std::string_view table, const std::vector<std::string>& known) {
    const bool isPart = formats::isPartOfName(key, formats::nearestName(key, known));  // "layout" of "layouts"
    const std::string hint = formats::nearestHint(key, known), elsewhere = isPart ? "" : sectionsWith(key);
    if (!elsewhere.empty()) return fmt::format("found the key '{}' in {}, expected it {}", key, table, elsewhere);
    return fmt::format("found unknown key '{}' in {}, expected one of its keys{}", key, table, hint.empty() ? ": " + listed(known) : hint);
}

std::string placeOf(const std::filesystem::path& file, const toml::source_position& at) {
    return fmt::format("{}:{}:{}", file.string(), at.line, at.column);
}

}  // namespace

TableReader::TableReader(const toml::table& table, std::filesystem::path file, std::string_view section)
    : table_(table), file_(std::move(file)), name_(section.empty() ? "the scene" : section), section_(sceneSection(section)) {
    refuseUnknownKeys();
}

void TableReader::fail(const toml::node& node, const std::string& detail) const {
    throw TomlMistake{{ErrorCode::InvalidRequest, placeOf(file_, node.source().begin), detail}};
}

void TableReader::failType(const toml::node& node, const char* key, std::string_view expected) const {
    fail(node, fmt::format("found {} for {}.{}, expected {}", typedValue(node), name_, key, expected));
}

void TableReader::check(const char* key, const Objection& objection) const {
    if (objection) fail(node(key), fmt::format("found {} for {}.{}, expected {}", objection->found, name_, key, objection->expected));
}

std::optional<double> TableReader::fraction(const char* key, const char* expected) {
    requireRow(key);
    const toml::node* node = table_.get(key);
    if (node == nullptr || !node->is_string()) return optional<double>(key, expected);
    const std::string text = node->value_or(std::string());
    const auto value = parseFraction(text);
    if (!value || !text.ends_with('%')) failType(*node, key, expected);
    return value;
}

std::optional<int> TableReader::positiveInteger(const char* key, std::int64_t most) {
    const auto value = optional<std::int64_t>(key, "a positive integer");
    if (value && (*value < 1 || *value > most))
        fail(node(key), fmt::format("found {} for {}.{}, expected an integer from 1 to {}", *value, name_, key, most));
    return value ? std::optional(static_cast<int>(*value)) : std::nullopt;
}

std::string TableReader::oneOf(const char* key, const std::vector<std::string>& choices, const std::string& otherwise) {
    std::string value = optional<std::string>(key, "a string").value_or(otherwise);
    if (std::find(choices.begin(), choices.end(), value) == choices.end())
        fail(*table_.get(key), fmt::format("found {} for {}.{}, expected one of: {}{}", inQuotes(value), name_, key, listed(choices),
                                           formats::nearestHint(value, choices)));
    return value;
}

std::optional<std::filesystem::path> TableReader::optionalPath(const char* key) {
    const auto text = optional<std::string>(key, "a path");
    if (!text) return std::nullopt;
    return pathOf(key, *text);
}

std::filesystem::path TableReader::pathOf(const char* key, const std::string& text) {
    if (text.empty()) fail(node(key), fmt::format("found an empty path for {}.{}, expected a path", name_, key));
    checkPath(node(key), key, text);
    return resolve(text);
}

void TableReader::checkPath(const toml::node& node, std::string_view key, const std::string& text) const {
    if (text.find('\0') != std::string::npos)
        fail(node, fmt::format("found a character 0 in the path {} for {}.{}, expected none", inQuotes(text), name_, key));
}

const toml::array* TableReader::array(const char* key, const char* expected) {
    requireRow(key);
    const toml::node* node = table_.get(key);
    if (node != nullptr && !node->is_array()) failType(*node, key, expected);
    return node == nullptr ? nullptr : node->as_array();
}

std::optional<std::vector<double>> TableReader::numbers(const char* key, const char* expected) {
    const toml::array* array = this->array(key, expected);
    if (array == nullptr) return std::nullopt;
    std::vector<double> values;
    for (const toml::node& element : *array) {
        const std::optional<double> value = element.is_number() ? element.value<double>() : std::nullopt;
        if (!value || !std::isfinite(*value))
            fail(element, fmt::format("found {} in {}.{}, expected {}", typedValue(element), name_, key, expected));
        values.push_back(*value);
    }
    return values;
}

std::optional<Range> TableReader::range(const char* key, double lowest, double highest) {
    const std::string expected = fmt::format("[low, high] with {} <= low <= high <= {}", lowest, highest);
    const auto values = numbers(key, expected.c_str());
    if (!values) return std::nullopt;
    check(key, objectionToRange(*values, lowest, highest));
    return Range{(*values)[0], (*values)[1]};
}

const toml::table* TableReader::table(const char* key) {
    const toml::node* node = table_.get(key);
    if (node == nullptr) return nullptr;
    if (!node->is_table()) fail(*node, fmt::format("found {} for '{}', expected a table [{}]", typedValue(*node), key, key));
    return node->as_table();
}

const toml::table& TableReader::requiredTable(const char* key, const char* expected) {
    requireRow(key);
    const toml::node& value = node(key);
    if (!value.is_table()) failType(value, key, expected);
    return *value.as_table();
}

std::vector<const toml::table*> TableReader::tables(const char* key) {
    std::vector<const toml::table*> found;
    const toml::node* node = table_.get(key);
    if (node == nullptr) return found;
    const toml::array* array = node->as_array();
    if (array == nullptr && section_.name.empty())
        fail(*node, fmt::format("found {} for '{}', expected tables [[{}]]", typedValue(*node), key, key));
    if (array == nullptr) failType(*node, key, fmt::format("tables [[{}.{}]]", name_, key));
    for (const toml::node& element : *array) {
        if (!element.is_table()) fail(element, fmt::format("found {} in '{}', expected a table", typedValue(element), key));
        found.push_back(element.as_table());
    }
    return found;
}

std::string TableReader::place(const char* key) const {
    return placeOf(file_, table_.get(key)->source().begin);
}

void TableReader::refuseUnknownKeys() const {
    std::vector<std::string> known = formats::namesOf(std::span<const SceneKeyInfo>(section_.keys));
    if (section_.name.empty())  // sections are keys of the root
        for (const SceneSectionInfo& section : allSceneSections())
            if (!section.name.empty()) known.emplace_back(section.name);
    for (const auto& [key, node] : table_) {
        const std::string name(key.str());
        if (std::find(known.begin(), known.end(), name) != known.end()) continue;
        throw TomlMistake{{ErrorCode::InvalidRequest, placeOf(file_, key.source().begin), unknownKey(name, name_, known)}};
    }
}

void TableReader::requireRow(std::string_view key) const {
    if (formats::findByName(std::span<const SceneKeyInfo>(section_.keys), key) == nullptr)
        throw std::logic_error(fmt::format("the key '{}' of {} has no row", key, name_));
}

}  // namespace lightcook::pipeline
