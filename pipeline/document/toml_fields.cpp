#include "pipeline/document/toml_fields.h"

#include <cmath>
#include <cstdint>

#include "pipeline/document/written_path.h"

namespace lightcook::pipeline {
namespace {

using formats::ErrorCode;

/// Returns a value as messages name it: with its type.
std::string valueWithType(const toml::node& node) {
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

/// Returns the tables that have a key: "in [output] or [[light_map]]". Empty: none has it.
std::string tablesWith(std::span<const KeyTable> tables, std::string_view key) {
    std::string text;
    for (const KeyTable& table : tables) {
        if (formats::findByName(std::span<const KeyRow>(table.keys), key) == nullptr) continue;
        text += text.empty() ? "" : " or ";
        text += table.name.empty() ? "before the first table"
                : table.isArray    ? fmt::format("in [[{}]]", table.name)
                                   : fmt::format("in [{}]", table.name);
    }
    return text;
}

/// Leaves out the middle of a text that holds a long value: what was expected is at its end.
std::string withoutMiddle(const std::string& text) {
    constexpr std::size_t kLongest = 4000, kKept = 500;
    if (text.size() <= kLongest) return text;
    const auto isInsideOfCharacter = [&](std::size_t at) { return (static_cast<unsigned char>(text[at]) & 0xC0) == 0x80; };
    std::size_t end = kKept, next = text.size() - kKept;
    while (isInsideOfCharacter(end)) --end;
    while (isInsideOfCharacter(next)) --next;
    return text.substr(0, end) + " ... " + text.substr(next);
}

}  // namespace

formats::Subject TomlDocument::placeOf(const toml::source_position& at) const {
    if (at.line == 0) return file;
    return formats::Subject::inLine(file, static_cast<int>(at.line), static_cast<int>(at.column));
}

formats::Subject TomlDocument::placeOf(const toml::node& node) const {
    const auto option = given.find(&node);
    return option == given.end() ? placeOf(node.source().begin) : formats::Subject(option->second);
}

void TomlDocument::fail(const toml::node& node, const std::string& detail) const {
    throw TomlMistake{{ErrorCode::InvalidRequest, placeOf(node), withoutMiddle(detail)}};
}

const toml::table* TomlDocument::table(std::string_view section, std::size_t index) const {
    if (section.empty()) return &root;
    const toml::node* node = root.get(section);
    if (node != nullptr && node->is_array()) node = node->as_array()->get(index);
    return node == nullptr ? nullptr : node->as_table();  // what else it is, the reader of the section refuses
}

const toml::node* TomlDocument::find(std::string_view section, std::size_t index, std::string_view key) const {
    const toml::table* found = table(section, index);
    return found == nullptr ? nullptr : found->get(key);
}

const toml::node* TomlDocument::findForRule(std::string_view section, std::size_t index, std::string_view key) const {
    const std::size_t dot = key.find('.');
    return dot == std::string_view::npos ? find(section, index, key) : find(key.substr(0, dot), 0, key.substr(dot + 1));
}

void TomlDocument::hold(std::string_view section, std::size_t index, const std::vector<SettingsRule>& rules) const {
    for (const SettingsRule& rule : rules) {
        const toml::node* const node = rule.isBroken ? findForRule(section, index, rule.key) : nullptr;
        if (node == nullptr) continue;
        const toml::node* const beside = rule.beside.empty() ? nullptr : findForRule(section, index, rule.beside);
        const bool isBesideByOption = beside != nullptr && isGiven(*beside) && !isGiven(*node);
        const bool isKeyByOption = beside != nullptr && isGiven(*node) && !isGiven(*beside);
        if (rule.idle != Idle::Refused && isBesideByOption) continue;
        if (rule.idle == Idle::Either && isKeyByOption) continue;
        fail(isBesideByOption ? *beside : *node, rule.words);
    }
}

void TomlValue::refuse(std::string_view found, std::string_view expected) const {
    if (document_.isGiven(node_)) fail(fmt::format("found '{}', expected {}", optionTextOf(node_), expected));
    fail(fmt::format("found {} for {}, expected {}", found, name_, expected));
}

void TomlValue::refuseType(std::string_view expected) const {
    refuse(valueWithType(node_), expected);
}

bool TomlValue::flag(std::string_view expected) const {
    const auto value = node_.value_exact<bool>();  // numbers are none
    if (!value) refuseType(expected);
    return *value;
}

std::int64_t TomlValue::integer(std::string_view expected) const {
    const auto value = node_.is_boolean() ? std::nullopt : node_.value<std::int64_t>();  // toml++ converts true to 1
    if (!value) refuseType(expected);
    return *value;
}

double TomlValue::number(std::string_view expected) const {
    const auto value = node_.is_boolean() ? std::nullopt : node_.value<double>();
    if (!value) refuseType(expected);
    return *value;
}

double TomlValue::fraction(std::string_view expected) const {
    if (!isText()) return number(expected);
    const std::string text = node_.value_or(std::string());
    const auto value = text.ends_with('%') ? parseFraction(text) : std::nullopt;
    if (!value) refuseType(expected);
    return *value;
}

std::uint64_t TomlValue::byteCount(std::string_view expected) const {
    const auto bytes = parseByteCount(text(expected), place());
    if (!bytes) throw TomlMistake{bytes.error()};
    return *bytes;
}

std::string TomlValue::text(std::string_view expected) const {
    if (!isText()) refuseType(expected);
    return node_.value_or(std::string());
}

std::filesystem::path TomlValue::path(std::string_view expected) const {
    const std::string path = text(expected);
    if (path.empty()) refuse("an empty path", expected);
    if (path.find('\0') != std::string::npos) fail(fmt::format("found a character 0 in the path '{}' for {}, expected none", path, name_));
    std::filesystem::path file = (document_.directory / path).lexically_normal();
    if (const std::string fault = faultOfInput(path, file); !fault.empty()) fail(fault);
    return file;
}

std::vector<double> TomlValue::numbers(std::string_view expected) const {
    std::vector<double> values;
    for (const TomlValue& element : elements(expected)) {
        const std::optional<double> value = element.node_.is_number() ? element.node_.value<double>() : std::nullopt;
        if ((!value || !std::isfinite(*value)) && document_.isGiven(element.node_)) element.refuse("", expected);
        if (!value || !std::isfinite(*value))
            element.fail(fmt::format("found {} in {}, expected {}", valueWithType(element.node_), name_, expected));
        values.push_back(*value);
    }
    return values;
}

std::size_t TomlValue::oneOf(const std::vector<std::string>& names, std::string_view expected) const {
    const std::string name = text(expected);
    const auto found = std::ranges::find(names, name);
    if (found == names.end()) refuse(fmt::format("'{}'", name), fmt::format("{}{}", expected, formats::nearestHint(name, names)));
    return static_cast<std::size_t>(found - names.begin());
}

std::vector<TomlValue> TomlValue::elements(std::string_view expected) const {
    if (!node_.is_array()) refuseType(expected);
    std::vector<TomlValue> all;
    for (const toml::node& node : *node_.as_array()) all.emplace_back(document_, node, name_);
    return all;
}

std::vector<std::pair<std::string, TomlValue>> TomlValue::members(std::string_view expected, const std::vector<std::string>& names) const {
    if (!isTable()) refuseType(expected);
    refuseUnknownKeys(document_, *node_.as_table(), name_, names);
    std::vector<std::pair<std::string, TomlValue>> all;
    for (const auto& [key, node] : *node_.as_table()) {
        std::string name(key.str());
        TomlValue value(document_, node, fmt::format("{}.{}", name_, name));
        all.emplace_back(std::move(name), std::move(value));
    }
    return all;
}

void refuseUnknownKeys(const TomlDocument& document, const toml::table& table, std::string_view section,
                       const std::vector<std::string>& known) {
    if (known.empty()) return;
    for (const auto& [key, node] : table) {
        const std::string name(key.str());
        if (std::ranges::find(known, name) != known.end()) continue;
        const bool isPart = formats::isPartOfName(name, formats::nearestName(name, known));  // "layout" of "layouts"
        const std::string hint = formats::nearestHint(name, known), elsewhere = isPart ? "" : tablesWith(document.tables, name);
        const std::string expected = hint.empty() ? fmt::format(": {}", fmt::join(known, ", ")) : hint;
        throw TomlMistake{{ErrorCode::InvalidRequest, document.placeOf(key.source().begin),
                           elsewhere.empty()
                               ? fmt::format("found unknown key '{}' in {}, expected one of its keys{}", name, section, expected)
                               : fmt::format("found the key '{}' in {}, expected it {}", name, section, elsewhere)}};
    }
}

TomlFields::TomlFields(const TomlDocument& document, const toml::table& table, std::string section)
    : document_(document), table_(table), section_(std::move(section)) {
    std::vector<std::string> known;
    for (const KeyTable& each : document.tables) {
        if (each.name == section_)
            for (const KeyRow& row : each.keys) known.push_back(row.name);
        else if (section_.empty() && each.name.find('.') == std::string::npos)  // tables are keys of the root
            known.push_back(each.name);
    }
    refuseUnknownKeys(document, table, nameInMessages(), known);
}

void TomlFields::failMissing(std::string_view key, std::string_view expected) const {
    document_.fail(table_, fmt::format("found no key '{}' in {}, expected {}", key, nameInMessages(), expected));
}

const toml::table* TomlFields::tableOf(std::string_view key) const {
    const toml::node* node = table_.get(key);
    if (node != nullptr && !node->is_table())
        document_.fail(*node, fmt::format("found {} for '{}', expected a table [{}]", valueWithType(*node), key, nameOf(key)));
    return node == nullptr ? nullptr : node->as_table();
}

std::vector<const toml::table*> TomlFields::tablesOf(std::string_view key) const {
    std::vector<const toml::table*> tables;
    const toml::node* node = table_.get(key);
    if (node == nullptr) return tables;
    const std::string expected = fmt::format("tables [[{}]]", nameOf(key));
    if (!node->is_array()) at(key).refuseType(expected);
    for (const toml::node& element : *node->as_array()) {
        if (!element.is_table())
            document_.fail(element, fmt::format("found {} in {}, expected {}", valueWithType(element), nameOf(key), expected));
        tables.push_back(element.as_table());
    }
    return tables;
}

}  // namespace lightcook::pipeline
