// JSON schemas (draft 2020-12) of described structs, from the same list of fields that reads and writes them.
#pragma once

#include <cmath>
#include <string>
#include <string_view>

#include "pipeline/document/json_fields.h"

namespace lightcook::pipeline {

template <class T>
Json schemaOfType(const FieldRule& rule);

/// Collects the fields of a struct as properties of an object.
class FieldSchema {
public:
    template <class T>
    void required(std::string_view key, const T&, const FieldRule& rule, std::string_view caption) {
        add(key, schemaOfType<T>(rule), caption, true);
    }
    template <class T>
    void required(std::string_view key, const T& value, std::string_view caption) {
        required(key, value, FieldRule{}, caption);
    }
    template <class T>
    void optional(std::string_view key, const std::optional<T>&, const FieldRule& rule, std::string_view caption) {
        add(key, schemaOfType<T>(rule), caption, false);
    }
    template <class T>
    void optional(std::string_view key, const std::optional<T>& value, std::string_view caption) {
        optional(key, value, FieldRule{}, caption);
    }
    template <class T>
    void nullable(std::string_view key, const std::optional<T>&, const FieldRule& rule, std::string_view caption) {
        add(key, {{"anyOf", {schemaOfType<T>(rule), {{"type", "null"}}}}}, caption, true);
    }
    template <class T>
    void optionalIf(bool, std::string_view key, const std::optional<T>& value, const FieldRule& rule, std::string_view caption) {
        optional(key, value, rule, caption);
    }
    template <class T>
    void presentIf(bool, std::string_view key, const T&, std::string_view caption) {
        add(key, schemaOfType<T>({}), caption, false);
    }
    template <class DescribeInner>
    void object(std::string_view key, std::string_view caption, DescribeInner describeInner) {
        FieldSchema inner;
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

    Json properties_ = Json::object(), required_ = Json::array();
};

template <class T>
Json schemaOfType(const FieldRule& rule) {
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
        return list(schemaOfType<typename T::value_type>(rule), T::length(), T::length());
    } else if constexpr (IsArray<T>::value) {
        return list(schemaOfType<typename T::value_type>(rule), std::tuple_size_v<T>, std::tuple_size_v<T>);
    } else if constexpr (IsVector<T>::value) {
        return list(schemaOfType<typename T::value_type>(rule), rule.leastCount, 0);
    } else if constexpr (IsMap<T>::value) {
        return {{"type", "object"}, {"additionalProperties", schemaOfType<typename T::mapped_type>(rule)}};
    } else if constexpr (std::same_as<T, std::string> || HasText<T>) {
        return {{"type", "string"}};
    } else if constexpr (HasMirror<T>) {
        return schemaOfType<typename FieldMirror<T>::Type>(rule);
    } else {
        FieldSchema fields;
        const T value{};
        describe(fields, value);
        return fields.schema();
    }
}

template <Described T>
Json schemaOf() {
    return schemaOfType<T>({});
}

}  // namespace lightcook::pipeline
