#include "pipeline/command/command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iterator>
#include <memory>
#include <sstream>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "formats/nearest.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/command/outputs.h"
#include "pipeline/command/reference/program_doc.h"
#include "pipeline/command/session.h"
#include "pipeline/command/terminal/terminal.h"
#include "pipeline/document/given_keys.h"
#include "pipeline/graph/version.h"
#include "pipeline/report/exit_codes.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

// One file each: cook.cpp, verify.cpp, ...
CommandFunction defineCook(CLI::App& app);
CommandFunction defineInit(CLI::App& app);
CommandFunction defineLint(CLI::App& app);
CommandFunction defineEstimate(CLI::App& app);
CommandFunction defineVerify(CLI::App& app);
CommandFunction defineReport(CLI::App& app);
CommandFunction defineView(CLI::App& app);
CommandFunction definePlan(CLI::App& app);
CommandFunction defineWork(CLI::App& app);
CommandFunction defineRepack(CLI::App& app);
CommandFunction defineLightmap(CLI::App& app);
CommandFunction defineDominant(CLI::App& app);
CommandFunction defineCubemap(CLI::App& app);
CommandFunction defineLut(CLI::App& app);
CommandFunction defineRsrm(CLI::App& app);
CommandFunction defineEncode(CLI::App& app);
CommandFunction defineDecode(CLI::App& app);
CommandFunction defineReconstruct(CLI::App& app);
CommandFunction defineCompare(CLI::App& app);
CommandFunction defineDiff(CLI::App& app);
CommandFunction defineInfo(CLI::App& app);
CommandFunction defineDemo(CLI::App& app);
CommandFunction defineHelp(CLI::App& app);

namespace {

constexpr std::array kCommands = {
    CommandInfo{"cook", "Cook a whole scene, incrementally, and verify it", defineCook, FolderUse::CooksAndReports},
    CommandInfo{"init", "Write a first scene file for some bakes, meshes and environments", defineInit},
    CommandInfo{"lint", "Look for what is implausible in the inputs of a scene, before a cook", defineLint},
    CommandInfo{"estimate", "Estimate pages, memory and cook time of the light maps of meshes, before a bake", defineEstimate},
    CommandInfo{"verify", "Reopen a cooked scene; measure and bound its errors again from the files", defineVerify},
    CommandInfo{"report", "Print the memory and errors of a cooked scene; compare them with a baseline", defineReport, FolderUse::Reports},
    CommandInfo{"view", "Show a cooked scene in the browser, beside its bake", defineView},
    CommandInfo{"plan", "Write the cook of a scene as a Ninja file, for a build system or a cluster", definePlan, FolderUse::Cooks},
    CommandInfo{"work", "Run one action of a cook on a node of a cluster", defineWork},
    CommandInfo{"repack", "Pack the charts of a light map anew, with fewer texels where its light is smooth", defineRepack},
    CommandInfo{"lightmap", "Compress one SH light map", defineLightmap, FolderUse::CooksAndReports},
    CommandInfo{"dominant", "Fit and compress the dominant light of one SH light map", defineDominant, FolderUse::CooksAndReports},
    CommandInfo{"cubemap", "Prefilter and pre-divide one environment, or take its diffuse light", defineCubemap,
                FolderUse::CooksAndReports},
    CommandInfo{"lut", "Make the tables of area-specular light", defineLut, FolderUse::CooksAndReports},
    CommandInfo{"rsrm", "Make the radially symmetric reflection map of one gradient", defineRsrm, FolderUse::CooksAndReports},
    CommandInfo{"encode", "Compress an image into a KTX2 or DDS texture", defineEncode},
    CommandInfo{"decode", "Decode a texture into a float EXR", defineDecode},
    CommandInfo{"reconstruct", "Write a cooked light map as the shader sees it, in the form of a bake", defineReconstruct},
    CommandInfo{"compare", "Print the differences of two images, textures, light maps or cooked scenes", defineCompare},
    CommandInfo{"diff", "Print the byte ranges in which a cooked scene differs from an older one, for a patch", defineDiff},
    CommandInfo{"info", "Print the contents of a file or a cooked scene", defineInfo},
    CommandInfo{"demo", "Cook, verify and report the scene that ships with the program", defineDemo, FolderUse::Cooks},
    CommandInfo{"help", "Print the help of the program or of one command", defineHelp},
};

/// Returns true for an option whose values are plain numbers, by the placeholder of its value. Sizes, fractions and percentages have
/// readers of their own.
bool takesNumbers(const CLI::Option& option) {
    constexpr std::array<std::string_view, 12> kOthers = {"TEXT",
                                                          "NAME",
                                                          "COMMAND",
                                                          "URL",
                                                          "SPACE",
                                                          kFilePlaceholder,
                                                          kFolderPlaceholder,
                                                          kSizePlaceholder,
                                                          kFractionPlaceholder,
                                                          kPercentPlaceholder,
                                                          kNumbersPlaceholder,
                                                          kNamesPlaceholder};
    const std::string type = option.get_type_name();
    return std::ranges::find(kOthers, std::string_view(type).substr(0, type.find(':'))) == kOthers.end();
}

/// Reads a finite decimal number, as a scene file has it. CLI11 alone takes "010" as 8, and "0x10", "1_000", "nan" and an empty text too.
/// Returns the mistake, or an empty text.
std::string readNumber(std::string& value) {
    double number = 0;
    const char* const end = value.data() + value.size();
    const auto [stop, error] = std::from_chars(value.data(), end, number);
    if (error != std::errc() || stop != end || !std::isfinite(number))
        return fmt::format("found '{}', expected a finite decimal number", value);
    value = fmt::format("{}", number);
    return "";
}

/// Refuses empty values, which are those of a script's variables that are not set, and numbers that are no decimal ones.
void refuseUnusableValues(CLI::App& app) {
    const auto refuseEmpty = [](const std::string& value) { return value.empty() ? std::string("found '', expected a value") : ""; };
    for (CLI::Option* option : app.get_options()) {
        if (option->get_items_expected_max() == 0) continue;  // a flag
        if (takesNumbers(*option))
            option->transform(CLI::Validator(readNumber, ""));
        else
            option->check(CLI::Validator(refuseEmpty, ""));
    }
}

/// Returns the names of the options of the program and of the commands that were given.
std::vector<std::string> optionNames(const CLI::App& app) {
    std::vector<std::string> names;
    for (const CLI::Option* option : app.get_options())
        for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    for (const CLI::App* command : app.get_subcommands()) std::ranges::copy(optionNames(*command), std::back_inserter(names));
    return names;
}

/// Returns "; nearest is '--layout'" for an option that is unknown: that of the key of [output] with this name, or else the nearest one.
std::string optionHint(const std::string& name, const std::vector<std::string>& known) {
    for (const KeyTable& table : sceneKeyTables())
        for (const KeyRow& row : table.keys)
            if (table.name == "output" && optionNamed(row.name) == name && !row.rule.option.empty())
                if (std::string option = optionNamed(std::string(row.rule.option)); std::ranges::find(known, option) != known.end())
                    return "; nearest is '" + option + "'";
    return formats::nearestHint(name, known);
}

/// Returns the message of CLI11 as an error: the option that it begins with is the subject. A word that is unknown is named with the
/// nearest one.
formats::Error errorOf(const CLI::App& app, const CLI::ParseError& mistake) {
    const std::vector<std::string> unknown = app.remaining(true);
    if (!unknown.empty() && dynamic_cast<const CLI::ExtrasError*>(&mistake) != nullptr) {
        const std::string name = unknown.front().substr(0, unknown.front().find('='));
        const std::string command = app.get_subcommands().empty() ? "" : app.get_subcommands().front()->get_name();
        const std::string of = command.empty() ? "" : " of " + command;
        const std::vector<std::string> known = optionNames(app);
        if (std::ranges::find(known, name) != known.end())
            return {formats::ErrorCode::InvalidRequest, "command line",
                    fmt::format("found '{}' before '{}', expected it after the command", name, command)};
        return {formats::ErrorCode::InvalidRequest, "command line",
                name.starts_with('-')
                    ? fmt::format("found the unknown option '{}', expected an option{}{}", name, of, optionHint(name, known))
                    : fmt::format("found '{}', expected no further argument{}", name, of)};
    }
    if (!unknown.empty() && app.get_subcommands().empty()) return unknownCommand(unknown.front());
    const std::string message = mistake.what();
    const std::size_t colon = message.starts_with('-') ? message.find(": ") : std::string::npos;
    if (colon == std::string::npos) return {formats::ErrorCode::InvalidRequest, "command line", message};
    const std::string name = message.substr(0, colon), detail = message.substr(colon + 2);
    const CLI::Option* option = app.get_option_no_throw(name);
    for (const CLI::App* command : app.get_subcommands())
        if (option == nullptr) option = command->get_option_no_throw(name);
    const bool isOfValue = dynamic_cast<const CLI::ValidationError*>(&mistake) != nullptr && !detail.starts_with("found ");
    if (option == nullptr || (!isOfValue && !option->results().empty())) return {formats::ErrorCode::InvalidRequest, name, detail};
    const OptionDoc doc = describeOption(*option);
    const std::string value = fmt::format("{}", fmt::join(option->results(), ","));
    return {formats::ErrorCode::InvalidRequest, name,
            fmt::format("found {}, expected {}{}", option->results().empty() ? "no value" : "'" + value + "'",
                        doc.choices.empty() ? doc.placeholder : fmt::format("one of: {}", fmt::join(doc.choices, ", ")),
                        formats::nearestHint(value, doc.choices))};
}

/// Names the options that exclude one in the order of their names: CLI11 has them in that of their addresses.
class SortedFormatter : public CLI::Formatter {
public:
    std::string make_option_opts(const CLI::Option* option) const override {
        constexpr std::string_view kExcludes = " Excludes:";
        std::string text = CLI::Formatter::make_option_opts(option);
        const std::size_t at = text.find(kExcludes);
        if (at == std::string::npos) return text;
        std::istringstream rest(text.substr(at + kExcludes.size()));
        std::vector<std::string> names{std::istream_iterator<std::string>(rest), {}};
        std::ranges::sort(names);
        return text.substr(0, at) + fmt::format("{} {}", kExcludes, fmt::join(names, " "));
    }
};

}  // namespace

std::span<const CommandInfo> allCommands() {
    return kCommands;
}

formats::Error unknownCommand(const std::string& name) {
    std::vector<std::string> names;
    for (const CommandInfo& command : kCommands) names.emplace_back(command.name);
    return {formats::ErrorCode::InvalidRequest, "command line",
            fmt::format("found the unknown command '{}', expected one of: {}{}", name, fmt::join(names, ", "),
                        formats::nearestHint(name, names))};
}

void defineProgram(CLI::App& app, GlobalOptions& global, CommandFunction& selected) {
    app.formatter(std::make_shared<SortedFormatter>());
    app.name("lightcook");
    app.description("lightcook compresses baked lighting into GPU textures and certifies the error of the shaded result.");
    app.set_version_flag("-V,--version", fmt::format("{} {}", kToolName, kToolVersion), "Print the version and exit");
    app.set_help_flag("-h,--help", "Print this help and exit");
    app.require_subcommand(1);
    app.fallthrough();
    app.add_option("--log", global.log, "Format of error messages")->check(CLI::IsMember({"text", "json"}))->capture_default_str();
    app.add_option("--color", global.color, "Colours; auto: on a terminal, unless NO_COLOR is set")
        ->check(CLI::IsMember({"auto", "always", "never"}))
        ->capture_default_str();
    CLI::Option* quiet =
        app.add_flag("-q,--quiet", global.quiet,
                     "Print errors, warnings and what the command is asked for: no progress, no summary, no table of a cook");
    app.add_flag("-v,--verbose", global.verbose, "Print a line for each action: its time, or that it came from the cache")->excludes(quiet);
    app.add_option("-j,--threads", global.threads, "Number of threads; default: one for each core")->check(CLI::Range(1, 1024));
    app.add_option("--instructions", global.instructions, "Vector instructions that the encoders may use; the output is the same for both")
        ->check(CLI::IsMember({"widest", "avx2"}))
        ->capture_default_str();
    app.add_flag("--no-sandbox", global.noSandbox,
                 "Decode OpenEXR, OpenImageIO and Draco files in this process, for a debugger: one that is made to harm may take it over");
    for (const CommandInfo& command : kCommands) {
        CLI::App* sub = app.add_subcommand(std::string(command.name), std::string(command.summary));
        const CommandFunction function = command.define(*sub);
        sub->callback([&selected, function] { selected = function; });
        refuseUnusableValues(*sub);
    }
    refuseUnusableValues(app);
}

ParsedCommandLine parseCommandLine(int argc, const char* const* argv, GlobalOptions& global) {
    CLI::App app;
    ParsedCommandLine parsed;
    defineProgram(app, global, parsed.function);
    const auto refuse = [&](const formats::Error& error) {
        Terminal(global.terminal()).error(error);
        return ParsedCommandLine{{}, exitCode(formats::ErrorCode::InvalidRequest), {}};
    };
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& mistake) {
        if (mistake.get_exit_code() == 0) {  // --help, --version
            std::ostringstream text;
            const int code = app.exit(mistake, text, text);
            Terminal(global.terminal()).data(text.str());
            return {{}, code, {}};
        }
        if (argc < 2) Terminal(global.terminal()).data(app.help() + "\n");
        if (std::ranges::find(app.get_option("--log")->results(), "json") != app.get_option("--log")->results().end()) global.log = "json";
        return refuse(errorOf(app, mistake));
    }
    if (app.get_subcommands().empty()) return parsed;
    CLI::App& command = *app.get_subcommands().front();
    auto paths = CommandPaths::of(command);
    if (const auto checked = paths.check(); !checked) return refuse(checked.error());
    parsed.documents = FailureDocuments::of(command);
    parsed.function = [function = std::move(parsed.function), paths = std::move(paths), documents = parsed.documents](Session& session) {
        session.paths = paths;
        const int code = function(session);
        if (!session.errors.empty() && !session.hasWrittenDocuments && !session.paths.isRefused() && !session.state.interrupted)
            documents.write(session.errors, session.terminal);
        return code;
    };
    return parsed;
}

}  // namespace lightcook::pipeline
