// Keys of TOML documents: scene files and budgets. A struct lists its keys once, each with the values that it may have, its default and its
// caption; the reader (toml_fields.h), the check for unknown keys and the tables of the reference are derived from that list:
//
//   template <class Keys>
//   void describeKeys(Keys& keys, Basket& basket) {
//       keys.required("owner", basket.owner, {}, "who carries it");
//       keys.optional("pieces", basket.count, within(1, 99), "number of pieces");
//       keys.optional("sort", basket.sort, oneOf(allSorts()), "what is in it");
//   }
//
// A key of a std::optional may be absent; one of another type is the struct's own value then. A member may be a boolean, a number, a text,
// a path, an enumeration with a table of names, a type with a FieldText, a list of numbers, a glm vector, a map by name, or a std::optional
// of these. `special` is for keys of another shape, `section` and `sections` for tables inside the document.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "formats/vocabulary.h"
#include "pipeline/document/json_fields.h"

namespace lightcook::pipeline {

/// The two halves of the message "found ..., expected ...".
struct ValueError {
    std::string found, expected;
};
/// The error of a value that is not allowed; empty for one that is.
using Objection = std::optional<ValueError>;

/// Places where a key may have no effect.
enum class Idle {
    Refused,  ///< nowhere
    InFile,   ///< in a file, beside an option that overrides it
    Either    ///< there, and as an option that the file contradicts, since an option is given to all scenes
};

/// A combination of settings that is refused, at one of their keys: "mips" of the same table, "output.charts", ".lobe" of the root.
struct SettingsRule {
    std::string_view key;  ///< it holds in documents that give the key
    bool isBroken = false;
    std::string words;
    std::string_view beside = {};  ///< key that it contradicts, which is named where only that one is an option
    Idle idle = Idle::Refused;     ///< `key` has no effect then
};

/// A range of numbers.
struct Range {
    double low = 0, high = 0;
};

/// The form in which a key is written. A size is a text such as "2 MiB".
enum class KeyShape { Text, Size, Path, Flag, Integer, Number, Numbers, Texts, Table };

/// Values that a key may have, in numbers and in words.
struct KeyRule {
    bool isFraction = false;                               ///< also a text such as "2%"
    double low = -HUGE_VAL, high = HUGE_VAL;               ///< of numbers, which are finite
    bool (*allows)(double) = nullptr;                      ///< a condition on numbers beside the range
    std::vector<std::string> names = {};                   ///< of a text that is one of these; of a map, of its keys
    std::string (*faultOf)(const std::string&) = nullptr;  ///< "found ..., expected ..." of a text that is refused; empty for others
    std::string expected = {};                             ///< in messages; empty: by type and range
    std::string type = {};                                 ///< in Markdown, for the reference; empty: by type and range
    std::string fallback = {};                             ///< in Markdown: the default; empty: the value that the struct begins with
    std::string_view of = {};            ///< "output.mips": the key that this one goes before, and whose option removes it
    std::optional<KeyShape> shape = {};  ///< empty: by type
    std::string_view option = {};        ///< name of its option, without dashes; empty: that of the key

    /// Returns the same rule with another default in the reference.
    KeyRule otherwise(std::string text) const {
        KeyRule rule = *this;
        rule.fallback = std::move(text);
        return rule;
    }
    /// Returns the same rule for a key that goes before another one.
    KeyRule before(std::string_view key) const {
        KeyRule rule = *this;
        rule.of = key;
        return rule;
    }
    bool isAllowed(double value) const {
        return std::isfinite(value) && value >= low && value <= high && (allows == nullptr || allows(value));
    }
};

inline KeyRule within(double low, double high) {
    return {.low = low, .high = high};
}
inline KeyRule oneOf(std::vector<std::string> names) {
    return {.names = std::move(names)};
}
template <class Row>
KeyRule oneOf(std::span<const Row> rows) {
    return oneOf(formats::namesOf(rows));
}
inline const KeyRule kByteCount = {.expected = "a size such as \"2 MiB\"", .type = "size"};

/// Returns "what. `a`: caption of a; `b`: caption of b" for the rows of a table.
template <class Row>
std::string withCaptions(std::string_view what, std::span<const Row> rows) {
    std::string text(what);
    for (const Row& row : rows) text += fmt::format("{}`{}`: {}", &row == rows.data() ? ". " : "; ", row.name, row.caption);
    return text;
}

/// Returns a name as the reference shows it: in quotes and code marks.
inline std::string inCode(std::string_view name) {
    return fmt::format("`\"{}\"`", name);
}

/// A row of the reference.
struct KeyRow {
    std::string name, type, fallback, caption;  ///< all but the name in Markdown
    KeyShape shape = KeyShape::Text;
    KeyRule rule = {};  ///< with the names of an enumeration
};

/// A table of a document, or the keys before the first table.
struct KeyTable {
    std::string name = {};               ///< "light_map", "light_map.place"; empty for the keys before the first table
    bool isArray = false;                ///< [[name]], any number of times
    std::string intro = {}, outro = {};  ///< Markdown before and after the keys
    std::vector<KeyRow> keys = {};
};

/// Markdown before and after the keys of a table in the reference.
struct SectionText {
    std::string intro = {}, outro = {};
};

namespace key_words {

template <class T>
struct Inner {
    using Type = T;
};
template <class T>
struct Inner<std::optional<T>> {
    using Type = T;
};
template <class T>
inline constexpr bool kIsOptional = !std::same_as<T, typename Inner<T>::Type>;
template <class T>
inline constexpr bool kIsNumber = std::floating_point<T> || json_fields::Integer<T>;

/// Returns the names that a text or an enumeration may have; empty: any.
template <class T>
std::vector<std::string> namesFor(const KeyRule& rule) {
    if constexpr (std::is_enum_v<T>)
        return rule.names.empty() ? enumNames<T>() : rule.names;
    else
        return rule.names;
}

/// Returns the type of a key as the reference has it.
template <class T>
std::string typeOf(const KeyRule& rule) {
    if (!rule.type.empty()) return rule.type;
    if constexpr (std::same_as<T, bool>) return "true, false";
    if constexpr (std::same_as<T, std::filesystem::path>) return "path";
    if constexpr (kIsNumber<T>) {
        const std::string_view type = std::floating_point<T> ? "number" : "integer";
        if (!std::isfinite(rule.high)) return std::string(type);
        return std::floating_point<T> ? fmt::format("number from {:g} to {:g}", rule.low, rule.high)
                                      : fmt::format("{} to {}", rule.low, rule.high);
    }
    std::string names;
    for (const std::string& name : namesFor<T>(rule)) names += (names.empty() ? "" : ", ") + inCode(name);
    return names.empty() ? "string" : names;
}

/// Returns the shape of a key.
template <class T>
KeyShape shapeOf(const KeyRule& rule) {
    if (rule.shape) return *rule.shape;
    if constexpr (std::same_as<T, bool>) return KeyShape::Flag;
    if constexpr (std::same_as<T, std::filesystem::path>) return KeyShape::Path;
    if constexpr (std::same_as<T, std::uint64_t>) return KeyShape::Size;
    if constexpr (kIsNumber<T>) return std::floating_point<T> ? KeyShape::Number : KeyShape::Integer;
    if constexpr (json_fields::IsMap<T>::value) return KeyShape::Table;
    if constexpr (std::same_as<T, Range> || json_fields::IsArray<T>::value || json_fields::IsGlm<T>::value) return KeyShape::Numbers;
    return KeyShape::Text;
}

/// Returns the values of a key as messages expect them.
template <class T>
std::string expectedOf(const KeyRule& rule) {
    if (!rule.expected.empty()) return rule.expected;
    if constexpr (std::same_as<T, bool>) return "true or false";
    if constexpr (std::same_as<T, std::filesystem::path>) return "a path";
    if constexpr (HasText<T>) return FieldText<T>::expected();
    if constexpr (kIsNumber<T>) {
        const std::string_view type = std::floating_point<T> ? "a number" : "an integer";
        return std::isfinite(rule.high) ? fmt::format("{} from {} to {}", type, rule.low, rule.high) : std::string(type);
    }
    const std::vector<std::string> names = namesFor<T>(rule);
    return names.empty() ? "a string" : fmt::format("one of: {}", fmt::join(names, ", "));
}

/// Returns the default of a key as the reference has it: by the rule, or the value that the struct begins with.
template <class T>
std::string fallbackOf(const T& value, const KeyRule& rule) {
    if (!rule.fallback.empty()) return rule.fallback;
    if constexpr (std::same_as<T, bool> || kIsNumber<T>) return fmt::format("{}", value);
    if constexpr (std::is_enum_v<T>) return inCode(namesFor<T>(rule).at(static_cast<std::size_t>(value)));
    if constexpr (HasText<T>) return inCode(FieldText<T>::of(value));
    if constexpr (std::same_as<T, std::string>)
        if (!value.empty()) return inCode(value);
    return "none";
}

}  // namespace key_words

/// Lists the keys of a document for the reference, and the names that its reader knows.
class KeyLister {
public:
    /// tables  of the document; that of the number `at` gets the keys
    KeyLister(std::vector<KeyTable>& tables, std::size_t at) : tables_(tables), at_(at) {}

    template <class T>
    void required(std::string_view key, const T&, const KeyRule& rule, std::string_view caption) {
        add<T>(key, rule, "required", caption);
    }
    template <class T>
    void optional(std::string_view key, const T& value, const KeyRule& rule, std::string_view caption) {
        add<typename key_words::Inner<T>::Type>(key, rule, fallbackOf(key, rule, key_words::fallbackOf(value, rule)), caption);
    }
    template <class T>
    void requiredUnless(std::string_view other, std::string_view key, const T&, const KeyRule& rule, std::string_view caption) {
        add<T>(key, rule, fmt::format("required, or `{}`", other), caption);
    }
    template <class Read>
    void special(std::string_view key, const KeyRule& rule, std::string_view caption, Read) {
        add<std::string>(key, rule, fallbackOf(key, rule, "none"), caption);
    }
    template <class T, class DescribeInner>
    void section(std::string_view key, T& value, const SectionText& text, DescribeInner describeInner) {
        KeyLister inner = table(key, false, text);
        describeInner(inner, value);
    }
    template <class T, class DescribeInner>
    void sections(std::string_view key, std::vector<T>&, const SectionText& text, DescribeInner describeInner) {
        KeyLister inner = table(key, true, text);
        T element{};
        describeInner(inner, element);
    }
    /// Tables inside a table, which are also one of its keys.
    template <class T, class DescribeInner>
    void sectionsInside(std::string_view key, std::vector<T>& elements, const KeyRule& rule, std::string_view caption,
                        const SectionText& text, DescribeInner describeInner) {
        add<std::string>(key, {.type = "tables", .shape = KeyShape::Table}, rule.fallback, caption);
        sections(key, elements, text, describeInner);
    }

private:
    template <class T>
    void add(std::string_view key, const KeyRule& rule, std::string fallback, std::string_view caption) {
        KeyRow row{std::string(key),     key_words::typeOf<T>(rule),  std::move(fallback),
                   std::string(caption), key_words::shapeOf<T>(rule), rule};
        row.rule.names = key_words::namesFor<T>(rule);
        tables_[at_].keys.push_back(std::move(row));
    }
    /// Returns the default of a key: of one that goes before another, that one.
    static std::string fallbackOf(std::string_view key, const KeyRule& rule, const std::string& otherwise) {
        if (!rule.fallback.empty() || rule.of.empty()) return rule.fallback.empty() ? otherwise : rule.fallback;
        const std::string_view name = rule.of.substr(rule.of.find('.') + 1);
        return name == key ? "that of `[output]`" : fmt::format("`{}` of `[output]`", name);
    }
    KeyLister table(std::string_view key, bool isArray, const SectionText& text) {
        const std::string& outer = tables_[at_].name;
        tables_.push_back({outer.empty() ? std::string(key) : fmt::format("{}.{}", outer, key), isArray, text.intro, text.outro, {}});
        return {tables_, tables_.size() - 1};
    }

    std::vector<KeyTable>& tables_;
    std::size_t at_;
};

/// Returns every table of a document, in the order of the reference: the keys before the first one, then as described.
template <class Document>
const std::vector<KeyTable>& keyTablesOf() {
    static const std::vector<KeyTable> kTables = [] {
        std::vector<KeyTable> tables(1);
        KeyLister lister(tables, 0);
        Document document{};
        describeKeys(lister, document);
        return tables;
    }();
    return kTables;
}

}  // namespace lightcook::pipeline
