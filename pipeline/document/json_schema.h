// JSON schemas (draft 2020-12) of described structs, from the same list of fields that reads and writes them. Each struct is written once,
// under `$defs` by the name of its type, and named by `$ref` where it is used.
#pragma once

#include <cmath>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>

#include "pipeline/document/json_fields.h"

namespace lightcook::pipeline {

/// Value of `format` of a text that is the name of a file inside the cooked folder.
inline constexpr const char* kFileFormat = "file-in-folder";

/// Returns the name of a type with its namespaces: "lightcook::verify::ErrorPlace".
template <class T>
std::string_view qualifiedNameOf() {
    constexpr std::string_view kSignature = __PRETTY_FUNCTION__;  // "... [with T = lightcook::verify::ErrorPlace; ...]" or "... [T = ...]"
    constexpr std::size_t kStart = kSignature.find("T = ") + 4;
    return kSignature.substr(kStart, kSignature.find_first_of(";]", kStart) - kStart);
}

/// Schemas of structs, each under the name of its type.
class SchemaDefinitions {
public:
    /// Adds the schema of a struct unless it is there, and returns a reference to it.
    template <Described T>
    Json add(std::string_view qualifiedName = qualifiedNameOf<T>());
    /// Adds a schema that no struct has.
    Json add(const std::string& name, Json schema) {
        all_[name] = std::move(schema);
        return {{"$ref", "#/$defs/" + name}};
    }
    /// Returns them by name, in the order of their first uses.
    const Json& all() const { return all_; }

private:
    Json all_ = Json::object();
    std::map<std::string, std::string_view> qualifiedNames_;
};

template <class T>
Json schemaOfType(const FieldRule& rule, SchemaDefinitions& definitions);

/// Collects the fields of a struct as properties of an object.
class FieldSchema {
public:
    explicit FieldSchema(SchemaDefinitions& definitions) : definitions_(definitions) {}
    template <class T>
    void required(std::string_view key, const T&, const FieldRule& rule, std::string_view caption) {
        add(key, schemaOfType<T>(rule, definitions_), caption, true);
    }
    template <class T>
    void required(std::string_view key, const T& value, std::string_view caption) {
        required(key, value, FieldRule{}, caption);
    }
    template <class T>
    void optional(std::string_view key, const std::optional<T>&, const FieldRule& rule, std::string_view caption) {
        add(key, schemaOfType<T>(rule, definitions_), caption, false);
    }
    template <class T>
    void optional(std::string_view key, const std::optional<T>& value, std::string_view caption) {
        optional(key, value, FieldRule{}, caption);
    }
    template <class T>
    void nullable(std::string_view key, const std::optional<T>&, const FieldRule& rule, std::string_view caption) {
        add(key, {{"anyOf", {schemaOfType<T>(rule, definitions_), {{"type", "null"}}}}}, caption, true);
    }
    template <class T>
    void optionalIf(bool, std::string_view key, const std::optional<T>& value, const FieldRule& rule, std::string_view caption) {
        optional(key, value, rule, caption);
    }
    template <class T>
    void presentIf(bool, std::string_view key, const T&, std::string_view caption) {
        add(key, schemaOfType<T>({}, definitions_), caption, false);
    }
    template <class DescribeInner>
    void object(std::string_view key, std::string_view caption, DescribeInner describeInner) {
        FieldSchema inner(definitions_);
        describeInner(inner);
        add(key, inner.schema(), caption, true);
    }

    /// Returns the schema of an object that has these fields and no others.
    Json schema() const {
        Json schema = {{"type", "object"}, {"properties", properties_}};
        if (!required_.empty()) schema["required"] = required_;
        schema["additionalProperties"] = false;
        return schema;
    }

private:
    void add(std::string_view key, Json schema, std::string_view caption, bool isRequired) {
        if (properties_.contains(std::string(key))) return;  // a field whose place in the order depends on others comes twice
        schema["description"] = std::string(caption);
        properties_[std::string(key)] = std::move(schema);
        if (isRequired) required_.push_back(std::string(key));
    }

    SchemaDefinitions& definitions_;
    Json properties_ = Json::object(), required_ = Json::array();
};

/// Returns the schema of a struct.
template <Described T>
Json schemaOf(SchemaDefinitions& definitions) {
    FieldSchema fields(definitions);
    const T value{};
    describe(fields, value);
    return fields.schema();
}

template <Described T>
Json SchemaDefinitions::add(std::string_view qualifiedName) {
    const std::string name(qualifiedName.substr(qualifiedName.rfind(':') + 1));
    const auto [known, isNew] = qualifiedNames_.emplace(name, qualifiedName);
    if (known->second != qualifiedName) throw std::logic_error("two structs of a document have the name " + name);
    if (!isNew) return {{"$ref", "#/$defs/" + name}};
    add(name, nullptr);  // keeps its place before the structs inside it
    return add(name, schemaOf<T>(*this));
}

template <class T>
Json schemaOfType(const FieldRule& rule, SchemaDefinitions& definitions) {
    using namespace json_fields;
    const auto number = [&](const char* type) {
        Json schema = {{"type", type}};
        if (rule.mayBeNull) schema["type"] = {type, "null"};
        if (std::isfinite(rule.low)) schema["minimum"] = rule.low;
        if (std::isfinite(rule.high)) schema["maximum"] = rule.high;
        return schema;
    };
    const auto list = [](Json items, std::size_t least, std::size_t most) {
        Json schema = {{"type", "array"}, {"items", std::move(items)}};
        if (least > 0) schema["minItems"] = least;
        if (most > 0) schema["maxItems"] = most;
        return schema;
    };
    if constexpr (std::same_as<T, Json>) {
        return Json::object();
    } else if constexpr (std::same_as<T, bool>) {
        return {{"type", "boolean"}};
    } else if constexpr (Integer<T>) {
        return number("integer");
    } else if constexpr (std::floating_point<T>) {
        return number("number");
    } else if constexpr (std::is_enum_v<T>) {
        return {{"enum", enumNames<T>()}};
    } else if constexpr (IsGlm<T>::value) {
        return list(schemaOfType<typename T::value_type>(rule, definitions), T::length(), T::length());
    } else if constexpr (IsArray<T>::value) {
        return list(schemaOfType<typename T::value_type>(rule, definitions), std::tuple_size_v<T>, std::tuple_size_v<T>);
    } else if constexpr (IsVector<T>::value || IsSet<T>::value) {
        return list(schemaOfType<typename T::value_type>(rule, definitions), rule.leastCount, 0);
    } else if constexpr (IsMap<T>::value) {
        return {{"type", "object"}, {"additionalProperties", schemaOfType<typename T::mapped_type>(rule, definitions)}};
    } else if constexpr (std::same_as<T, std::string> || HasText<T>) {
        Json schema = {{"type", "string"}};
        if (rule.isFile) schema["format"] = kFileFormat;
        return schema;
    } else if constexpr (HasMirror<T>) {
        return definitions.add<typename FieldMirror<T>::Type>(qualifiedNameOf<T>());
    } else {
        return definitions.add<T>();
    }
}

/// Returns a schema as a document.
inline Json documentOf(const char* title, const Json& schema, const Json& definitions) {
    Json document = {{"$schema", "https://json-schema.org/draft/2020-12/schema"}, {"title", title}};
    document.update(schema);
    if (!definitions.empty()) document["$defs"] = definitions;
    return document;
}

/// Returns the schema of a struct as a document.
template <Described T>
Json documentSchema(const char* title) {
    SchemaDefinitions definitions;
    const Json schema = schemaOf<T>(definitions);
    return documentOf(title, schema, definitions.all());
}

}  // namespace lightcook::pipeline
