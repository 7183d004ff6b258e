#include "pipeline/document/toml_merge.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <system_error>
#include <vector>

#include "formats/vocabulary.h"

namespace lightcook::pipeline {
namespace {

/// Returns "output" and "target" of "output.target"; an empty text and "name" of "name".
std::pair<std::string_view, std::string_view> partsOf(std::string_view key) {
    const std::size_t dot = key.rfind('.');
    if (dot == std::string_view::npos) return {"", key};
    return {key.substr(0, dot), key.substr(dot + 1)};
}

/// Returns the tables of a section.
std::vector<toml::table*> tablesOf(toml::table& root, std::string_view section) {
    if (section.empty()) return {&root};
    std::vector<toml::table*> tables;
    toml::node* const node = root.get(section);
    if (node == nullptr) return tables;
    if (toml::table* const table = node->as_table()) tables.push_back(table);
    if (toml::array* const array = node->as_array())
        for (toml::node& element : *array)
            if (toml::table* const table = element.as_table()) tables.push_back(table);
    return tables;
}

/// Adds an empty table for a section that the document lacks.
void addSection(toml::table& root, const KeyTable& section) {
    if (section.name.empty() || root.contains(section.name)) return;
    if (section.isArray)
        root.insert(section.name, toml::array()).first->second.as_array()->push_back(toml::table());
    else
        root.insert(section.name, toml::table());
}

/// Returns a finite decimal number, as a TOML file has it but for zeros at its front.
std::optional<double> numberOf(std::string_view text) {
    double number = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(number)) return std::nullopt;
    return number;
}

/// Calls put(value) with a number, or with the text for the reader to refuse.
template <class Put>
void putNumber(const std::string& text, Put put) {
    constexpr double kMostExact = 0x1p53;
    const auto number = numberOf(text);
    if (!number)
        put(text);
    else if (*number == std::floor(*number) && std::abs(*number) <= kMostExact)
        put(static_cast<std::int64_t>(*number));
    else
        put(*number);
}

std::vector<std::string> splitAtCommas(const std::string& text) {
    std::vector<std::string> parts(1);
    for (const char c : text)
        if (c == ',')
            parts.emplace_back();
        else
            parts.back() += c;
    return parts;
}

/// Returns a path of the current folder as a document in another folder names it.
std::string pathFrom(const std::filesystem::path& directory, const std::string& given) {
    const std::filesystem::path path = given;
    if (given.empty() || path.is_absolute() || directory.empty()) return given;
    return std::filesystem::absolute(path)
        .lexically_normal()
        .lexically_relative(std::filesystem::absolute(directory).lexically_normal())
        .string();
}

void setKey(toml::table& table, const KeyRow& row, const std::string& value, const std::filesystem::path& directory) {
    const auto put = [&](auto&& any) { table.insert_or_assign(row.name, any); };
    switch (row.shape) {
        case KeyShape::Flag:
            if (value == "true" || value == "false") return put(value == "true");
            return put(value);
        case KeyShape::Integer:
        case KeyShape::Number:
            return putNumber(value, put);
        case KeyShape::Numbers:
        case KeyShape::Texts: {
            toml::array elements;
            const auto add = [&](const auto& element) { elements.push_back(element); };
            for (const std::string& part : splitAtCommas(value))
                if (row.shape == KeyShape::Texts)
                    add(part);
                else
                    putNumber(part, add);
            return put(elements);
        }
        case KeyShape::Path: {
            const bool isName = std::ranges::find(row.rule.names, value) != row.rule.names.end();
            return put(isName ? value : pathFrom(directory, value));
        }
        case KeyShape::Text:
        case KeyShape::Size:
        case KeyShape::Table:
            return put(value);
    }
}

}  // namespace

const KeyRow* keyRowOf(std::span<const KeyTable> tables, std::string_view key) {
    const auto [section, name] = partsOf(key);
    const auto table = std::ranges::find(tables, section, &KeyTable::name);
    return table == tables.end() ? nullptr : formats::findByName(std::span<const KeyRow>(table->keys), name);
}

GivenNodes mergeKeys(toml::table& root, std::span<const KeyTable> tables, const GivenKeys& given, const std::filesystem::path& directory) {
    GivenNodes nodes;
    for (const GivenKey& each : given.all()) {
        const KeyRow& row = *keyRowOf(tables, each.key);
        const KeyTable& section = *std::ranges::find(tables, partsOf(each.key).first, &KeyTable::name);
        addSection(root, section);
        for (toml::table* const table : tablesOf(root, section.name)) {
            setKey(*table, row, each.value, directory);
            toml::node* const node = table->get(row.name);
            nodes[node] = each.option;
            if (toml::array* const array = node->as_array())
                for (toml::node& element : *array) nodes[&element] = each.option;
        }
        for (const KeyTable& other : tables)
            for (const KeyRow& own : other.keys)
                if (own.rule.of == each.key)
                    for (toml::table* const table : tablesOf(root, other.name)) table->erase(own.name);
    }
    return nodes;
}

Json jsonOfToml(const toml::node& node) {
    if (const auto* text = node.as_string()) return text->get();
    if (const auto* flag = node.as_boolean()) return flag->get();
    if (const auto* integer = node.as_integer()) return integer->get();
    if (const auto* number = node.as_floating_point()) return number->get();
    if (const toml::array* const array = node.as_array()) {
        Json list = Json::array();
        for (const toml::node& element : *array) list.push_back(jsonOfToml(element));
        return list;
    }
    Json object = Json::object();
    if (const toml::table* const table = node.as_table())
        for (const auto& [key, member] : *table) object[std::string(key.str())] = jsonOfToml(member);
    return object;
}

toml::table tomlOfJson(const Json& document) {
    toml::table table;
    for (const auto& [key, value] : document.items()) {
        if (value.is_object())
            table.insert(key, tomlOfJson(value));
        else if (value.is_boolean())
            table.insert(key, value.get<bool>());
        else if (value.is_number_integer())
            table.insert(key, value.get<std::int64_t>());
        else if (value.is_number())
            table.insert(key, value.get<double>());
        else if (value.is_string())
            table.insert(key, value.get<std::string>());
        if (!value.is_array()) continue;
        toml::array array;
        for (const Json& element : value)
            if (const toml::table holder = tomlOfJson(Json{{"element", element}}); const toml::node* node = holder.get("element"))
                node->visit([&](const auto& any) { array.push_back(any); });
        table.insert(key, std::move(array));
    }
    return table;
}

std::string optionTextOf(const toml::node& node) {
    if (const toml::array* const array = node.as_array()) {
        std::string text;
        for (const toml::node& element : *array) text += (text.empty() ? "" : ",") + optionTextOf(element);
        return text;
    }
    if (const auto* text = node.as_string()) return text->get();
    if (const auto* flag = node.as_boolean()) return fmt::format("{}", flag->get());
    if (const auto* integer = node.as_integer()) return fmt::format("{}", integer->get());
    const auto* number = node.as_floating_point();
    return number == nullptr ? "" : fmt::format("{}", number->get());
}

}  // namespace lightcook::pipeline
