#include "pipeline/command/key_options.h"

#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <cctype>
#include <cmath>

#include "formats/nearest.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/document/toml_merge.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {
namespace {

/// Returns Markdown as plain text: the text of links, no marks of code. A link in parentheses is left out.
std::string plainText(std::string_view markdown) {
    std::string text;
    for (std::size_t i = 0; i < markdown.size(); ++i) {
        if (const std::size_t end = markdown.substr(i, 3) == " ([" ? markdown.find("))", i) : std::string_view::npos;
            end != std::string_view::npos) {
            i = end + 1;
            continue;
        }
        const std::size_t close = markdown[i] == '[' ? markdown.find(']', i) : std::string_view::npos;
        if (close != std::string_view::npos && markdown.substr(close + 1, 1) == "(") {
            text += plainText(markdown.substr(i + 1, close - i - 1));
            i = markdown.find(')', close);
        } else if (markdown[i] != '`') {
            text += markdown[i];
        }
    }
    return text;
}

/// Returns the caption of a key as the help of an option.
std::string helpOf(const KeyRow& row, bool isNegated) {
    std::string text = plainText(row.caption);
    const auto isLower = [&](std::size_t i) { return i < text.size() && std::islower(static_cast<unsigned char>(text[i])) != 0; };
    if (isNegated) text.insert(0, "do not ");
    if (isLower(0) && (isLower(1) || text[1] == ' ')) text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
    return text;
}

/// Returns the default of a key as an option shows it behind its name. Empty: none, or one of several words.
std::string shortDefaultOf(const KeyRow& row) {
    std::string text = plainText(row.fallback);
    if (text == "none" || text.find(' ') != std::string::npos) return "";
    std::erase(text, '"');
    return text;
}

/// Returns the placeholder of a value, and what it may be, in the notation of CLI11.
std::pair<std::string, std::string> valueOf(const KeyRow& row, const std::vector<std::string>& names) {
    const auto number = [&](const char* type) -> std::pair<std::string, std::string> {
        if (row.rule.isFraction) return {kFractionPlaceholder, ""};
        if (!std::isfinite(row.rule.high)) return {type, ""};
        return {type, fmt::format("{} in [{:.10g} - {:.10g}]", type, row.rule.low, row.rule.high)};
    };
    switch (row.shape) {
        case KeyShape::Size:
            return {kSizePlaceholder, ""};
        case KeyShape::Path:
            return {kFilePlaceholder, ""};
        case KeyShape::Integer:
            return number("INT");
        case KeyShape::Number:
            return number("NUMBER");
        case KeyShape::Numbers:
            return {kNumbersPlaceholder, ""};
        case KeyShape::Texts:
            return {kNamesPlaceholder, ""};
        case KeyShape::Text:
        case KeyShape::Flag:
        case KeyShape::Table:
            break;
    }
    return {"TEXT", names.empty() ? "" : fmt::format("{{{}}}", fmt::join(names, ","))};
}

}  // namespace

CLI::Option* addKeyOption(CLI::App& app, GivenKeys& given, const KeyOption& option, bool hasDefault) {
    const std::string key(option.key);
    const KeyRow& row = *keyRowOf(sceneKeyTables(), key);
    const bool isFlag = row.shape == KeyShape::Flag;
    std::string name(!option.name.empty() ? option.name : row.rule.option.empty() ? std::string_view(row.name) : row.rule.option);
    if (isFlag && option.name.empty() && row.fallback == "true") name.insert(0, "no-");
    name = optionNamed(name);
    if (isFlag) {
        const bool isNegated = name.starts_with("--no-");
        const auto set = [&given, key, name, isNegated](std::int64_t) { given.set(key, isNegated ? "false" : "true", name); };
        return app.add_flag_function(name, set, option.text.empty() ? helpOf(row, isNegated) : option.text);
    }
    const std::vector<std::string>& names = option.names.empty() ? row.rule.names : option.names;
    const auto check = [key, names = option.names, isList = row.shape == KeyShape::Texts](const std::string& value) {
        if (!names.empty() && std::ranges::find(names, value) == names.end())
            return fmt::format("found '{}', expected one of: {}{}", value, fmt::join(names, ", "), formats::nearestHint(value, names));
        if (value.empty() && isList) return std::string("found '', expected names");
        const std::string fault = faultOfKey(key, value);
        return value.empty() && fault.empty() ? "found '', expected a value" : fault;
    };
    const auto [placeholder, values] = valueOf(row, names);
    const bool hasOwnDefault = hasDefault && option.text.empty() && row.fallback != "none";
    const std::string shortDefault = hasOwnDefault ? shortDefaultOf(row) : "";
    std::string help = option.text.empty() ? helpOf(row, false) : plainText(option.text);
    if (hasOwnDefault && shortDefault.empty()) help += "; default: " + plainText(row.fallback);
    return app
        .add_option_function<std::string>(
            name, [&given, key, name](const std::string& value) { given.set(key, value, name); }, help)
        ->check(CLI::Validator(check, values))
        ->type_name(placeholder)
        ->default_str(shortDefault);
}

void addKeyOptions(CLI::App& app, GivenKeys& given, std::span<const KeyOption> options) {
    for (const KeyOption& option : options) addKeyOption(app, given, option);
}

void addOutputOptions(CLI::App& app, GivenKeys& given) {
    const std::string section = "output";
    for (const KeyTable& table : sceneKeyTables())
        if (table.name == section)
            for (const KeyRow& row : table.keys) addKeyOption(app, given, {section + "." + row.name}, false);
}

KeyOption sourceOption() {
    return {"color.source",
            "",
            {},
            "Colour space of the input, which is converted to lin_rec709. Default: stated, the primaries that the file states "
            "(chromaticities of OpenEXR, PRIMARIES of Radiance), else lin_rec709"};
}

std::vector<KeyOption> fileOptions() {
    return {{"output.container"},
            {"output.zstd"},
            {"output.budget", "", {}, "GPU memory of everything that is written, such as \"2 MiB\"; more ends with exit code 5"}};
}

std::vector<KeyOption> textureOptions() {
    std::vector<KeyOption> options = fileOptions();
    options.insert(options.begin(), {"output.target"});
    options.insert(options.end(), {{"output.effort"}, {"output.rdo"}});
    return options;
}

std::vector<KeyOption> converterLimitOptions() {
    return {
        {"output.max_converter_error",
         "max-error",
         {},
         "Limit on the error of the asset, on its own quantity; above it verification fails (exit code 4). Default: 0.1, of a cubemap 0.5"},
        {"output.max_converter_visible",
         "max-visible",
         {},
         "Limit on the visible error of the asset, in just noticeable differences that 99 % keep; above it verification fails"},
        {"output.max_converter_visible_bound",
         "max-visible-bound",
         {},
         "Limit on the proven bound of the visible error, which no place, normal or view exceeds; above it verification fails"}};
}

}  // namespace lightcook::pipeline
