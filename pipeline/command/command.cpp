#include "pipeline/command/command.h"

#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <system_error>
#include <utility>
#include <vector>

#include "pipeline/command/option_groups.h"
#include "pipeline/command/outputs.h"
#include "pipeline/command/session.h"
#include "pipeline/command/terminal/mistake.h"
#include "pipeline/command/terminal/terminal.h"
#include "pipeline/graph/version.h"
#include "pipeline/report/exit_codes.h"

namespace lightcook::pipeline {

// One file each: cook.cpp, verify.cpp, ...
CommandFunction defineCook(CLI::App& app);
CommandFunction defineInit(CLI::App& app);
CommandFunction defineLint(CLI::App& app);
CommandFunction defineVerify(CLI::App& app);
CommandFunction defineReport(CLI::App& app);
CommandFunction defineView(CLI::App& app);
CommandFunction definePlan(CLI::App& app);
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
CommandFunction defineInfo(CLI::App& app);
CommandFunction defineDemo(CLI::App& app);
CommandFunction defineHelp(CLI::App& app);

namespace {

constexpr std::array kCommands = {
    CommandInfo{"cook", "Cook a whole scene, incrementally, and verify it", defineCook, FolderUse::CooksAndReports},
    CommandInfo{"init", "Write a first scene file for some bakes, meshes and environments", defineInit},
    CommandInfo{"lint", "Look for what is implausible in the inputs of a scene, before a cook", defineLint},
    CommandInfo{"verify", "Reopen a cooked scene; measure and bound its errors again from the files", defineVerify},
    CommandInfo{"report", "Print the memory and errors of a cooked scene; compare them with a baseline", defineReport, FolderUse::Reports},
    CommandInfo{"view", "Show a cooked scene in the browser, beside its bake", defineView},
    CommandInfo{"plan", "Write the cook of a scene as a Ninja file, for a build system or a cluster", definePlan, FolderUse::Cooks},
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
    CommandInfo{"info", "Print the contents of a file or a cooked scene", defineInfo},
    CommandInfo{"demo", "Cook, verify and report the scene that ships with the program", defineDemo, FolderUse::Cooks},
    CommandInfo{"help", "Print the help of the program or of one command", defineHelp},
};

/// Returns true for an option whose values are numbers, by the placeholder of its value.
bool takesNumbers(const CLI::Option& option) {
    constexpr std::array<std::string_view, 5> kTexts = {"TEXT", "NAME", "COMMAND", kFilePlaceholder, kFolderPlaceholder};
    const std::string type = option.get_type_name();
    return std::ranges::find(kTexts, std::string_view(type).substr(0, type.find(':'))) == kTexts.end();
}

/// Returns true for "nan", "-inf", "1e999": CLI11 takes them as numbers, and NaN passes its ranges.
bool isNotFinite(const std::string& value) {
    char* end = nullptr;
    const double number = std::strtod(value.c_str(), &end);
    return !value.empty() && *end == '\0' && !std::isfinite(number);
}

/// Returns true for "16", "-0.5" and "1e-3". CLI11 takes "+2", "0x10" and "1_000" too, which no fraction or size may be.
bool isDecimal(const std::string& value) {
    double number = 0;
    const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
    return error != std::errc::invalid_argument && end == value.data() + value.size();
}

std::string notDecimal(const std::string& value) {
    return fmt::format("found '{}', expected a number in decimal digits", value);
}

/// Refuses a number that is not finite or not decimal. Returns the mistake, or an empty text. CLI11 itself refuses what is no number.
/// mayHaveUnit  for sizes, such as "2 MiB"
std::string mistakeInNumber(const std::string& value, bool mayHaveUnit) {
    if (isNotFinite(value)) return fmt::format("found '{}', expected a finite number", value);
    const bool beginsAsNumber = value.find_first_of("+-.0123456789 ") == 0;
    if (beginsAsNumber && !mayHaveUnit && !isDecimal(value)) return notDecimal(value);
    return "";
}

/// Takes the zeros off the front of a number: CLI11 would read the rest of a whole number in base 8. Refuses "00x3", which would become
/// hexadecimal.
std::string withoutLeadingZeros(std::string& value) {
    const std::size_t first = value.starts_with('-') ? 1 : 0;
    std::size_t digit = first;
    while (digit + 1 < value.size() && value[digit] == '0' && value[digit + 1] >= '0' && value[digit + 1] <= '9') ++digit;
    if (digit > first && value.find_first_of("xX", digit) == digit + 1) return notDecimal(value);
    value.erase(first, digit - first);
    return "";
}

/// Refuses empty values, which are those of a script's variables that are not set: CLI11 would take an empty number as 0.
/// Refuses numbers that are not finite or not decimal. Zeros at the front of a number mean nothing.
void refuseUnusableValues(CLI::App& app) {
    for (CLI::Option* option : app.get_options()) {
        if (option->get_items_expected_max() == 0) continue;  // a flag
        const std::string type = option->get_type_name();
        const bool isPath = type.starts_with(kFilePlaceholder) || type.starts_with(kFolderPlaceholder);
        const std::string mistake = isPath ? "found '', expected a path" : "empty";
        option->check(CLI::Validator([mistake](const std::string& value) { return value.empty() ? mistake : std::string(); }, ""));
        if (!takesNumbers(*option)) continue;
        const bool isSize = type.starts_with(kSizePlaceholder);
        option->check(CLI::Validator([isSize](const std::string& value) { return mistakeInNumber(value, isSize); }, ""));
        option->transform(CLI::Validator(withoutLeadingZeros, ""));
    }
}

}  // namespace

std::span<const CommandInfo> allCommands() {
    return kCommands;
}

void defineProgram(CLI::App& app, GlobalOptions& global, CommandFunction& selected) {
    app.name("lightcook");
    app.description("lightcook compresses baked lighting into GPU textures and certifies the error of the shaded result.");
    app.set_version_flag("--version", fmt::format("{} {}", kToolName, kToolVersion), "Print the version and exit");
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
    const std::vector<std::string> arguments(argv + std::min(argc, 1), argv + argc);
    const auto refuse = [&](const formats::Error& error, const CommandPaths& paths = {}) {
        Terminal terminal(global.terminal());
        terminal.error(error);
        writeFailure(arguments, {error}, terminal, paths);
        return ParsedCommandLine{{}, exitCode(formats::ErrorCode::InvalidRequest)};
    };
    try {
        app.parse(argc, argv);
    } catch (const CLI::ParseError& mistake) {
        if (mistake.get_exit_code() == 0) return {{}, app.exit(mistake)};  // --help, --version
        if (arguments.empty()) fmt::print("{}\n", app.help());
        // An option after the mistake is not read by then.
        const std::array<std::string, 2> wanted = {"--log", "json"};
        if (std::search(arguments.begin(), arguments.end(), wanted.begin(), wanted.end()) != arguments.end() ||
            std::ranges::find(arguments, "--log=json") != arguments.end())
            global.log = "json";
        return refuse(firstMistake(arguments, mistake.what()));
    }
    if (app.get_subcommands().empty()) return parsed;
    auto paths = CommandPaths::of(*app.get_subcommands().front());
    if (const auto checked = paths.check(); !checked) return refuse(checked.error(), paths);
    parsed.function = [function = std::move(parsed.function), paths = std::move(paths), arguments](Session& session) {
        session.paths = paths;
        const OlderDocuments older(arguments);
        session.atInterrupt([older] { older.remove(); });
        const int code = function(session);
        if (session.state.interrupted && !session.paths.isRefused()) older.remove();
        if (!session.errors.empty() && !session.hasWrittenDocuments && !session.paths.isRefused())
            writeFailure(arguments, session.errors, session.terminal);
        return code;
    };
    return parsed;
}

}  // namespace lightcook::pipeline
