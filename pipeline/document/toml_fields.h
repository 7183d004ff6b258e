// Reads the keys that a struct describes (keys.h) from the tables of a TOML file. The first mistake is thrown with its file, line and
// column, what was found and what was expected; readToml returns it as an error.
#pragma once

#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "formats/nearest.h"
#include "pipeline/document/byte_count.h"
#include "pipeline/document/keys.h"
#include "pipeline/document/toml_file.h"
#include "pipeline/document/toml_merge.h"

namespace lightcook::pipeline {

/// A TOML file that is read.
struct TomlDocument {
    std::filesystem::path file;
    const toml::table& root;
    std::span<const KeyTable> tables;      ///< of keyTablesOf()
    std::string_view name;                 ///< of the keys before the first table, for messages: "the scene"
    std::filesystem::path directory = {};  ///< that paths are relative to
    GivenNodes given = {};                 ///< values of options
    bool isPartial = false;                ///< required keys may be missing

    bool isGiven(const toml::node& node) const { return given.contains(&node); }
    /// Returns the option that gave a value, or else file, line and column.
    formats::Subject placeOf(const toml::node& node) const;
    formats::Subject placeOf(const toml::source_position& at) const;
    [[noreturn]] void fail(const toml::node& node, const std::string& detail) const;
    /// Returns the table of a section, element `index` of an array of tables; nullptr without it. Of no section: the root.
    const toml::table* table(std::string_view section, std::size_t index = 0) const;
    /// Returns the value of a key; nullptr without it.
    const toml::node* find(std::string_view section, std::size_t index, std::string_view key) const;
    /// Returns the same of a key of a rule, which may name a table of its own: "output.charts", ".lobe".
    const toml::node* findForRule(std::string_view section, std::size_t index, std::string_view key) const;
    /// Refuses the first broken rule of a table whose key is given. The place is that of the key, or of the one beside it if that alone is
    /// an option.
    void hold(std::string_view section, std::size_t index, const std::vector<SettingsRule>& rules) const;
};

/// The value of a key. Each reader refuses other types.
class TomlValue {
public:
    /// name  for messages: "output.target"
    TomlValue(const TomlDocument& document, const toml::node& node, std::string name)
        : document_(document), node_(node), name_(std::move(name)) {}

    const std::string& name() const { return name_; }
    formats::Subject place() const { return document_.placeOf(node_); }
    [[noreturn]] void fail(const std::string& detail) const { document_.fail(node_, detail); }
    /// Fails with "found <found> for <name>, expected <expected>", or with the text that an option gave.
    [[noreturn]] void refuse(std::string_view found, std::string_view expected) const;
    void check(const Objection& objection) const {
        if (objection) refuse(objection->found, objection->expected);
    }

    bool isText() const { return node_.is_string(); }
    bool isTable() const { return node_.is_table(); }
    bool flag(std::string_view expected) const;
    std::int64_t integer(std::string_view expected) const;
    double number(std::string_view expected) const;
    /// Reads a number, or a text such as "2%".
    double fraction(std::string_view expected) const;
    std::uint64_t byteCount(std::string_view expected) const;
    std::string text(std::string_view expected) const;
    /// Reads a path relative to the file. A path with a character 0 is refused: the system would open the file of the part before it.
    std::filesystem::path path(std::string_view expected) const;
    std::vector<double> numbers(std::string_view expected) const;
    /// Reads one of some names, and returns its index.
    std::size_t oneOf(const std::vector<std::string>& names, std::string_view expected) const;
    std::vector<TomlValue> elements(std::string_view expected) const;
    /// names  that the members may have; empty: any
    std::vector<std::pair<std::string, TomlValue>> members(std::string_view expected, const std::vector<std::string>& names = {}) const;
    /// Fails with the value and its type: "found the integer 3 for <name>, expected <expected>".
    [[noreturn]] void refuseType(std::string_view expected) const;

private:
    const TomlDocument& document_;
    const toml::node& node_;
    std::string name_;
};

/// Refuses keys that a table does not have, with the nearest one, or with the tables that have them.
/// section  for messages
/// known    keys of the table; empty: any
void refuseUnknownKeys(const TomlDocument& document, const toml::table& table, std::string_view section,
                       const std::vector<std::string>& known);

template <class T>
void readKey(const TomlValue& place, T& value, const KeyRule& rule) {
    using namespace key_words;
    const std::string expected = expectedOf<T>(rule);
    if constexpr (kIsOptional<T>) {
        readKey(place, value.emplace(), rule);
    } else if constexpr (std::same_as<T, bool>) {
        value = place.flag(expected);
    } else if constexpr (std::same_as<T, std::filesystem::path>) {
        value = place.path(expected);
    } else if constexpr (std::is_enum_v<T>) {
        if (rule.faultOf != nullptr && place.isText())
            if (const std::string fault = rule.faultOf(place.text(expected)); !fault.empty()) place.fail(fault);
        value = static_cast<T>(place.oneOf(namesFor<T>(rule), expected));
    } else if constexpr (HasText<T>) {
        const std::string text = place.text(expected);
        const auto read = FieldText<T>::from(text);
        if (!read) place.refuse(fmt::format("'{}'", text), expected);
        value = *read;
    } else if constexpr (std::same_as<T, std::string>) {
        value = place.text(expected);
        if (rule.faultOf != nullptr)
            if (const std::string fault = rule.faultOf(value); !fault.empty()) place.fail(fault);
        if (!rule.names.empty()) place.oneOf(rule.names, expected);
    } else if constexpr (json_fields::IsMap<T>::value) {
        for (const auto& [key, member] : place.members(expected, rule.names)) readKey(member, value[key], kByteCount);
    } else if constexpr (std::same_as<T, Range>) {
        const std::vector<double> pair = place.numbers(expected);
        if (pair.size() != 2 || !(rule.low <= pair[0] && pair[0] <= pair[1] && pair[1] <= rule.high))
            place.refuse(fmt::format("[{}]", fmt::join(pair, ", ")), expected);
        value = {pair[0], pair[1]};
    } else if constexpr (json_fields::IsArray<T>::value || json_fields::IsGlm<T>::value) {
        const std::vector<double> numbers = place.numbers(expected);
        constexpr std::size_t kCount = sizeof(T) / sizeof(double);
        if (numbers.size() != kCount || !std::ranges::all_of(numbers, [&](double each) { return rule.isAllowed(each); }))
            place.refuse(fmt::format("[{}]", fmt::join(numbers, ", ")), expected);
        std::ranges::copy(numbers, &value[0]);
    } else if constexpr (std::same_as<T, std::uint64_t>) {
        value = place.byteCount(expected);
    } else if constexpr (json_fields::Integer<T>) {
        const std::int64_t number = place.integer(expected);
        if (!rule.isAllowed(static_cast<double>(number))) place.refuse(fmt::format("{}", number), expected);
        value = static_cast<T>(number);
    } else {
        const double number = rule.isFraction ? place.fraction(expected) : place.number(expected);
        if (!rule.isAllowed(number)) place.refuse(fmt::format("{}", number), expected);
        value = number;
    }
}

/// Reads the keys of one table. Keys that it does not have are refused before any is read.
class TomlFields {
public:
    /// section  of `document.tables`
    TomlFields(const TomlDocument& document, const toml::table& table, std::string section);

    template <class T>
    void required(std::string_view key, T& value, const KeyRule& rule, std::string_view) {
        if (!has(key) && document_.isPartial) return;
        if (!has(key)) failMissing(key, key_words::expectedOf<T>(rule));
        readKey(at(key), value, rule);
    }
    template <class T>
    void optional(std::string_view key, T& value, const KeyRule& rule, std::string_view) {
        if (has(key)) readKey(at(key), value, rule);
    }
    /// Reads a key that stands in place of another one.
    template <class T>
    void requiredUnless(std::string_view other, std::string_view key, T& value, const KeyRule& rule, std::string_view caption) {
        if (!has(other)) return required(key, value, rule, caption);
        if (has(key)) at(other).fail(fmt::format("found {} beside {}, expected one of them", nameOf(other), nameOf(key)));
    }
    /// Calls read(TomlValue) if the key is there.
    template <class Read>
    void special(std::string_view key, const KeyRule&, std::string_view, Read read) {
        if (has(key)) read(at(key));
    }
    template <class T, class DescribeInner>
    void section(std::string_view key, T& value, const SectionText&, DescribeInner describeInner) {
        if (const toml::table* table = tableOf(key)) {
            TomlFields inner(document_, *table, nameOf(key));
            describeInner(inner, value);
        }
    }
    template <class T, class DescribeInner>
    void sections(std::string_view key, std::vector<T>& elements, const SectionText&, DescribeInner describeInner) {
        for (const toml::table* table : tablesOf(key)) {
            TomlFields inner(document_, *table, nameOf(key));
            describeInner(inner, elements.emplace_back());
        }
    }
    template <class T, class DescribeInner>
    void sectionsInside(std::string_view key, std::vector<T>& elements, const KeyRule&, std::string_view, const SectionText& text,
                        DescribeInner describeInner) {
        sections(key, elements, text, describeInner);
    }

private:
    bool has(std::string_view key) const { return table_.contains(key); }
    std::string nameInMessages() const { return section_.empty() ? std::string(document_.name) : section_; }
    std::string nameOf(std::string_view key) const { return section_.empty() ? std::string(key) : fmt::format("{}.{}", section_, key); }
    TomlValue at(std::string_view key) const { return {document_, *table_.get(key), nameOf(key)}; }
    [[noreturn]] void failMissing(std::string_view key, std::string_view expected) const;
    const toml::table* tableOf(std::string_view key) const;
    std::vector<const toml::table*> tablesOf(std::string_view key) const;

    const TomlDocument& document_;
    const toml::table& table_;
    std::string section_;
};

/// Reads what a document describes from the root of a file.
template <class Document>
void readKeys(const TomlDocument& document, Document& value) {
    TomlFields fields(document, document.root, "");
    describeKeys(fields, value);
}

}  // namespace lightcook::pipeline
