// JSON as structs. A struct lists its fields once, with key, range and caption; reading, writing, shape checks and the tables of the
// reference documents are derived from that list:
//
//   struct Fruit { std::string name; int seedCount = 0; std::optional<double> massGrams; };
//   template <class Fields, Is<Fruit> Self>
//   void describe(Fields& fields, Self& fruit) {
//       fields.required("name", fruit.name, "name of the sort");
//       fields.required("seeds", fruit.seedCount, between(0, 100), "number of seeds");
//       fields.optional("mass", fruit.massGrams, "mass [g]");
//   }
//   const Json json = toJson(fruit);
//   const formats::Result<Fruit> fruit = fromJson<Fruit>(json, "basket.json");
//
// `Fields` is one of three visitors: FieldWriter, FieldReader and FieldSchema (json_schema.h), from which the reference is made. Keys keep
// the order of the list. A field may be text, a boolean, a number, an enumeration with a table of names, a type with a FieldText, a glm
// vector, a described struct, or Json where its shape is open; and a std::vector, std::array, std::set, std::map<std::string, ...> or
// std::optional of these.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "pipeline/document/json_place.h"

namespace lightcook::pipeline {

template <class Self, class T>
concept Is = std::same_as<std::remove_const_t<Self>, T>;

/// Range of a field. It holds for each number of a list or map of numbers.
struct FieldRule {
    double low = -HUGE_VAL, high = HUGE_VAL;
    bool mayBeNull = false;      ///< null stands for a number that is not finite
    std::size_t leastCount = 0;  ///< of the elements of a list
    bool isFile = false;         ///< the name of a file inside the cooked folder
};
constexpr FieldRule between(double low, double high) {
    return {.low = low, .high = high};
}
/// An error or a mean of light: at least 0, and null where it is not finite.
inline constexpr FieldRule kFigure = {.low = 0, .mayBeNull = true};
inline constexpr FieldRule kNumberOrNull = {.mayBeNull = true};
inline constexpr FieldRule kFileInFolder = {.isFile = true};
constexpr FieldRule atLeast(std::size_t count) {
    return {.leastCount = count};
}

/// Names of an enumeration's values, in their order; specialized where an enumeration is a field.
template <class Enum>
struct EnumNames;
template <class Enum>
const std::vector<std::string>& enumNames() {
    static const std::vector<std::string> kNames = EnumNames<Enum>::all();
    return kNames;
}

/// Specialized for a type whose JSON has another shape than its members: the fields of `Type` stand for it.
///   using Type = ...;  static Type of(const T&);  static T from(const Type&);
template <class T>
struct FieldMirror;
template <class T>
concept HasMirror = requires {
    typename FieldMirror<T>::Type;
};

/// Specialized for a type that JSON has as a text.
///   static std::string of(const T&);  static std::optional<T> from(const std::string&);  static std::string expected();
template <class T>
struct FieldText;
template <class T>
concept HasText = requires(const T& value) {
    FieldText<T>::of(value);
};

namespace json_fields {

template <class T>
struct IsVector : std::false_type {};
template <class T>
struct IsVector<std::vector<T>> : std::true_type {};
template <class T>
struct IsArray : std::false_type {};
template <class T, std::size_t N>
struct IsArray<std::array<T, N>> : std::true_type {};
template <class T>
struct IsSet : std::false_type {};
template <class T>
struct IsSet<std::set<T>> : std::true_type {};
template <class T>
struct IsMap : std::false_type {};
template <class T>
struct IsMap<std::map<std::string, T>> : std::true_type {};
template <class T>
struct IsGlm : std::false_type {};
template <glm::length_t N, class T, glm::qualifier Q>
struct IsGlm<glm::vec<N, T, Q>> : std::true_type {};

template <class T>
concept Integer = std::integral<T> && !std::same_as<T, bool>;

}  // namespace json_fields

template <class T>
Json jsonOf(const T& value);
template <class T>
void readValue(const JsonPlace& place, T& value, const FieldRule& rule);

/// Writes the fields of a struct into an object.
class FieldWriter {
public:
    explicit FieldWriter(Json& out) : out_(out) {}
    template <class T>
    void required(std::string_view key, const T& value, const FieldRule&, std::string_view) {
        out_[std::string(key)] = jsonOf(value);
    }
    template <class T>
    void required(std::string_view key, const T& value, std::string_view caption) {
        required(key, value, FieldRule{}, caption);
    }
    template <class T>
    void optional(std::string_view key, const std::optional<T>& value, const FieldRule&, std::string_view) {
        if (value) out_[std::string(key)] = jsonOf(*value);
    }
    template <class T>
    void optional(std::string_view key, const std::optional<T>& value, std::string_view caption) {
        optional(key, value, FieldRule{}, caption);
    }
    /// A field that is always there, and null where it has no value.
    template <class T>
    void nullable(std::string_view key, const std::optional<T>& value, const FieldRule&, std::string_view) {
        out_[std::string(key)] = value ? jsonOf(*value) : Json(nullptr);
    }
    /// Writes an optional field only if isHere: for a field whose place in the order depends on others.
    template <class T>
    void optionalIf(bool isHere, std::string_view key, const std::optional<T>& value, const FieldRule& rule, std::string_view caption) {
        if (isHere) optional(key, value, rule, caption);
    }
    /// Writes the field only if isPresent; a reader leaves a missing one at its default.
    template <class T>
    void presentIf(bool isPresent, std::string_view key, const T& value, std::string_view) {
        if (isPresent) out_[std::string(key)] = jsonOf(value);
    }
    /// Fields of a nested object that has no struct of its own: describeInner(visitor).
    template <class DescribeInner>
    void object(std::string_view key, std::string_view, DescribeInner describeInner) {
        Json inner = Json::object();
        FieldWriter writer(inner);
        describeInner(writer);
        out_[std::string(key)] = std::move(inner);
    }

private:
    Json& out_;
};

/// Reads the fields of a struct from an object. Keys that the struct does not list are ignored.
class FieldReader {
public:
    explicit FieldReader(JsonPlace place) : place_(std::move(place)) { place_.object(); }
    template <class T>
    void required(std::string_view key, T& value, const FieldRule& rule, std::string_view) {
        readValue(place_[key], value, rule);
    }
    template <class T>
    void required(std::string_view key, T& value, std::string_view caption) {
        required(key, value, FieldRule{}, caption);
    }
    template <class T>
    void optional(std::string_view key, std::optional<T>& value, const FieldRule& rule, std::string_view) {
        value.reset();
        if (place_.has(key)) readValue(place_[key], value.emplace(), rule);
    }
    template <class T>
    void optional(std::string_view key, std::optional<T>& value, std::string_view caption) {
        optional(key, value, FieldRule{}, caption);
    }
    template <class T>
    void nullable(std::string_view key, std::optional<T>& value, const FieldRule& rule, std::string_view) {
        value.reset();
        if (const JsonPlace place = place_[key]; !place.value().is_null()) readValue(place, value.emplace(), rule);
    }
    template <class T>
    void optionalIf(bool, std::string_view key, std::optional<T>& value, const FieldRule& rule, std::string_view caption) {
        optional(key, value, rule, caption);
    }
    template <class T>
    void presentIf(bool, std::string_view key, T& value, std::string_view) {
        if (place_.has(key)) readValue(place_[key], value, FieldRule{});
    }
    template <class DescribeInner>
    void object(std::string_view key, std::string_view, DescribeInner describeInner) {
        FieldReader reader(place_[key]);
        describeInner(reader);
    }

private:
    JsonPlace place_;
};

/// A struct with a function describe().
template <class T>
concept Described = requires(FieldWriter& fields, const T& value) {
    describe(fields, value);
};

template <class T>
Json jsonOf(const T& value) {
    using namespace json_fields;
    if constexpr (std::same_as<T, Json> || std::same_as<T, std::string> || std::same_as<T, bool> || Integer<T>) {
        return value;
    } else if constexpr (std::floating_point<T>) {
        return std::isfinite(value) ? Json(static_cast<double>(value)) : Json(nullptr);
    } else if constexpr (std::is_enum_v<T>) {
        return enumNames<T>().at(static_cast<std::size_t>(value));
    } else if constexpr (IsGlm<T>::value) {
        Json list = Json::array();
        for (glm::length_t i = 0; i < T::length(); ++i) list.push_back(jsonOf(value[i]));
        return list;
    } else if constexpr (IsVector<T>::value || IsArray<T>::value || IsSet<T>::value) {
        Json list = Json::array();
        for (const auto& each : value) list.push_back(jsonOf(each));
        return list;
    } else if constexpr (IsMap<T>::value) {
        Json object = Json::object();
        for (const auto& [key, member] : value) object[key] = jsonOf(member);
        return object;
    } else if constexpr (HasText<T>) {
        return FieldText<T>::of(value);
    } else if constexpr (HasMirror<T>) {
        return jsonOf(FieldMirror<T>::of(value));
    } else {
        Json object = Json::object();
        FieldWriter writer(object);
        describe(writer, value);
        return object;
    }
}

template <class T>
void readValue(const JsonPlace& place, T& value, const FieldRule& rule) {
    using namespace json_fields;
    if constexpr (std::same_as<T, Json>) {
        value = place.value();
    } else if constexpr (std::same_as<T, std::string>) {
        value = rule.isFile ? place.fileInFolder() : place.text();
    } else if constexpr (std::same_as<T, bool>) {
        value = place.flag();
    } else if constexpr (Integer<T>) {
        constexpr double kLargest = static_cast<double>(std::int64_t{1} << (sizeof(T) >= 8 ? 60 : 31)) - (sizeof(T) >= 8 ? 0 : 1);
        constexpr double kLowest = std::is_signed_v<T> ? -kLargest : 0;
        value = static_cast<T>(place.integer(static_cast<std::int64_t>(std::max(rule.low, kLowest)),
                                             static_cast<std::int64_t>(std::min(rule.high, kLargest))));
    } else if constexpr (std::floating_point<T>) {
        value = static_cast<T>(rule.mayBeNull ? place.numberOrNull(rule.low, rule.high) : place.number(rule.low, rule.high));
    } else if constexpr (std::is_enum_v<T>) {
        value = static_cast<T>(place.oneOf(enumNames<T>()));
    } else if constexpr (IsGlm<T>::value) {
        constexpr glm::length_t kCount = T::length();
        if (place.count() != static_cast<std::size_t>(kCount)) place.fail("a list of " + std::to_string(kCount));
        for (glm::length_t i = 0; i < kCount; ++i) readValue(place.element(static_cast<std::size_t>(i)), value[i], rule);
    } else if constexpr (IsArray<T>::value) {
        if (place.count() != value.size()) place.fail("a list of " + std::to_string(value.size()));
        for (std::size_t i = 0; i < value.size(); ++i) readValue(place.element(i), value[i], rule);
    } else if constexpr (IsVector<T>::value) {
        value.resize(place.count(rule.leastCount));
        for (std::size_t i = 0; i < value.size(); ++i) readValue(place.element(i), value[i], rule);
    } else if constexpr (IsSet<T>::value) {
        std::vector<typename T::value_type> list;
        readValue(place, list, rule);
        value = {list.begin(), list.end()};
    } else if constexpr (IsMap<T>::value) {
        value.clear();
        place.eachMember([&](const std::string& key, const JsonPlace& member) { readValue(member, value[key], rule); });
    } else if constexpr (HasText<T>) {
        const auto read = FieldText<T>::from(place.text());
        if (!read) place.fail(FieldText<T>::expected());
        value = *read;
    } else if constexpr (HasMirror<T>) {
        typename FieldMirror<T>::Type mirror{};
        readValue(place, mirror, rule);
        value = FieldMirror<T>::from(mirror);
    } else {
        FieldReader reader(place);
        describe(reader, value);
    }
}

template <Described T>
Json toJson(const T& value) {
    return jsonOf(value);
}

/// subject  the document, for the error, which names the place of the first value of a wrong shape
template <Described T>
formats::Result<T> fromJson(const Json& json, const formats::Subject& subject) {
    return checkedJson(json, subject, [](const JsonPlace& root) {
        T value{};
        readValue(root, value, FieldRule{});
        return value;
    });
}

}  // namespace lightcook::pipeline
