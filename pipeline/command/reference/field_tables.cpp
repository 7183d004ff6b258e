#include "pipeline/command/reference/field_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <vector>

#include "pipeline/document/json_schema.h"

namespace lightcook::pipeline {
namespace {

/// Returns a link to the table of a struct.
std::string linkTo(const std::string& reference) {
    const std::string name = reference.substr(reference.rfind('/') + 1);
    std::string anchor = name;
    std::ranges::transform(anchor, anchor.begin(), [](unsigned char letter) { return static_cast<char>(std::tolower(letter)); });
    return fmt::format("[{}](#{})", name, anchor);
}

std::string typeOf(const Json& schema);

std::string typesOf(const Json& schemas) {
    std::vector<std::string> types;
    for (const Json& schema : schemas) types.push_back(typeOf(schema));
    return fmt::format("{}", fmt::join(types, " or "));
}

/// Returns "numbers" of "number" and "lists of numbers" of "list of numbers".
std::string pluralOf(const std::string& type) {
    if (type.starts_with("list ")) return "lists" + type.substr(4);
    return std::ranges::all_of(type, [](unsigned char letter) { return std::islower(letter) != 0; }) ? type + "s" : type;
}

std::string listOf(const Json& schema) {
    const Json least = schema.value("minItems", Json()), most = schema.value("maxItems", Json());
    const std::string elements = pluralOf(typeOf(schema.at("items")));
    return !least.is_null() && least == most ? fmt::format("list of {} {}", least.dump(), elements) : "list of " + elements;
}

/// Returns the type of a value in words: "list of 3 numbers", "number or null", "[StageError](#stageerror)".
std::string typeOf(const Json& schema) {
    if (schema.contains("$ref")) return linkTo(schema["$ref"].get<std::string>());
    if (schema.contains("anyOf")) return typesOf(schema["anyOf"]);
    if (schema.contains("enum")) return fmt::format("`{}`", fmt::join(schema["enum"].get<std::vector<std::string>>(), "`, `"));
    if (!schema.contains("type")) return "any";
    if (schema["type"].is_array()) return fmt::format("{}", fmt::join(schema["type"].get<std::vector<std::string>>(), " or "));
    const auto type = schema["type"].get<std::string>();
    if (type == "array") return listOf(schema);
    if (type == "object" && !schema.contains("properties")) return "by name: " + typeOf(schema.at("additionalProperties"));
    return schema.value("format", "") == kFileFormat ? "file of the folder" : type;
}

/// Adds a row for each property of an object, and for those of objects inside it that are no structs.
void addRows(const Json& schema, const std::string& prefix, std::string& text) {
    const Json required = schema.value("required", Json::array());
    const auto addRow = [&](const std::string& name, const Json& property, bool isRequired) {
        text += fmt::format("| `{}{}` | {}{} | {} |\n", prefix, name, typeOf(property), isRequired ? "" : ", optional",
                            property.value("description", ""));
    };
    for (const auto& [name, property] : schema.at("properties").items()) {
        addRow(name, property, std::ranges::find(required, Json(name)) != required.end());
        if (property.contains("properties")) addRows(property, prefix + name + ".", text);
    }
    if (schema.at("additionalProperties").is_object()) addRow("*", schema["additionalProperties"], false);
}

std::string tableOf(const Json& schema) {
    std::string text = "| field | type | meaning |\n| --- | --- | --- |\n";
    addRows(schema, "", text);
    return text;
}

}  // namespace

std::string fieldTables(const Json& schema) {
    std::string text = tableOf(schema);
    if (schema.contains("$defs"))
        for (const auto& [name, definition] : schema["$defs"].items()) text += fmt::format("\n## {}\n\n{}", name, tableOf(definition));
    return text;
}

}  // namespace lightcook::pipeline
