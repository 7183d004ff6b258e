#include "pipeline/command/option_groups.h"

#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Formatter.hpp>
#include <array>
#include <cctype>
#include <utility>

#include "formats/vocabulary.h"
#include "pipeline/document/byte_count.h"
#include "pipeline/graph/user_settings.h"
#include "pipeline/manifest/cook_record.h"

namespace lightcook::pipeline {

CLI::Option* addFileOption(CLI::App& app, const std::string& names, std::filesystem::path& file, const std::string& description) {
    return app.add_option(names, file, description)->type_name(kFilePlaceholder);
}

CLI::Option* addFilesOption(CLI::App& app, const std::string& names, std::vector<std::filesystem::path>& files,
                            const std::string& description) {
    return app.add_option(names, files, description)->type_name(kFilePlaceholder);
}

CLI::Option* addFolderOption(CLI::App& app, const std::string& names, std::filesystem::path& folder, const std::string& description) {
    return app.add_option(names, folder, description)->type_name(kFolderPlaceholder);
}

CLI::Option* addFoldersOption(CLI::App& app, const std::string& names, std::vector<std::filesystem::path>& folders,
                              const std::string& description) {
    return app.add_option(names, folders, description)->type_name(kFolderPlaceholder);
}

std::string helpOf(const KeyRow& setting, std::string what) {
    if (what.empty()) what = setting.caption;
    what[0] = static_cast<char>(std::toupper(what[0]));
    return fmt::format("{}; default: {}", what, defaultOf(setting));
}

void addCacheOption(CLI::App& app, std::filesystem::path& cache, const std::string& what) {
    const KeyRow& setting = *formats::findByName(std::span<const KeyRow>(cacheKeyTable().keys), "folder");
    addFolderOption(app, optionOf(setting), cache, helpOf(setting, what));
}

namespace {

/// A declaration is a validator of this name that accepts everything: CLI11 keeps nothing else of ours with an option.
constexpr std::array<std::pair<Written, const char*>, 3> kDeclarations = {{
    {Written::File, "writes a file"},
    {Written::FileOrFolder, "writes a file or a folder"},
    {Written::Folder, "writes a folder"},
}};

}  // namespace

CLI::Option* declareWritten(CLI::Option* option, Written written) {
    for (const auto& [each, name] : kDeclarations)
        if (each == written) option->check(CLI::Validator([](const std::string&) { return std::string(); }, "", name));
    return option;
}

Written writtenBy(CLI::Option& option) {
    for (const auto& [each, name] : kDeclarations) try {
            option.get_validator(name);
            return each;
        } catch (const CLI::OptionNotFound&) {  // the next one
        }
    return Written::No;
}

CLI::Option* addPercentOption(CLI::App& app, const std::string& names, std::optional<double>& value, const std::string& description) {
    const auto convert = [](std::string& text) {
        const auto number = parseFraction(text);
        if (!number || *number < 0) return fmt::format("found '{}', expected a percentage such as 2 or 2%, at least 0", text);
        text = fmt::format("{}", text.ends_with('%') ? 100 * *number : *number);
        return std::string();
    };
    return app.add_option(names, value, description)->transform(CLI::Validator(convert, ""))->type_name(kPercentPlaceholder);
}

void addStrictOption(CLI::App& app, bool& strict) {
    app.add_flag("--strict", strict, "Treat warnings of lint that the scene file does not allow as errors (exit code 3)");
}

void addRepairOption(CLI::App& app, bool& repair) {
    app.add_flag("--repair", repair,
                 "Repair values that no light has (NaN, infinite, negative; in light maps also bands that are too long, and fireflies) and "
                 "count them, instead of refusing the file");
}

void addSamplesOption(CLI::App& app, std::optional<int>& samples) {
    app.add_option("--samples", samples, "Random places on the surface at which the verifier shades, per texel")
        ->check(CLI::Range(0, kMostSamples));
}

}  // namespace lightcook::pipeline
