// lightcook help: the help of the program or of one command.
#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <memory>

#include "pipeline/command/command.h"
#include "pipeline/command/outputs.h"
#include "pipeline/command/reference/program_doc.h"
#include "pipeline/command/session.h"

namespace lightcook::pipeline {
namespace {

Json jsonOf(const OptionDoc& option) {
    Json json = {{"names", option.names}, {"description", option.description}, {"required", option.isRequired}};
    if (option.isPositional) json["positional"] = true;
    if (!option.placeholder.empty()) json["value"] = option.placeholder;
    if (!option.choices.empty()) json["choices"] = option.choices;
    if (!option.fallback.empty()) json["default"] = option.fallback;
    return json;
}

Json jsonOf(const std::vector<OptionDoc>& options) {
    Json list = Json::array();
    for (const OptionDoc& option : options) list.push_back(jsonOf(option));
    return list;
}

/// Returns the commands, or the one that is named, with their options.
Json describe(const ProgramDoc& program, const std::string& command) {
    Json commands = Json::array();
    for (const CommandDoc& each : program.commands)
        if (command.empty() || each.name == command)
            commands.push_back({{"name", each.name}, {"summary", each.summary}, {"notes", each.notes}, {"options", jsonOf(each.options)}});
    return {{"summary", program.summary}, {"options", jsonOf(program.options)}, {"commands", std::move(commands)}};
}

}  // namespace

CommandFunction defineHelp(CLI::App& app) {
    struct Options {
        std::string command;
        JsonOutput json;
    };
    const auto options = std::make_shared<Options>();
    app.add_option("command", options->command, "The command; default: all of them")->type_name("COMMAND");
    options->json.add(app, "commands and options");
    return [options](Session& session) {
        options->json.prepare(session);
        CLI::App program;
        GlobalOptions global;
        CommandFunction selected;
        defineProgram(program, global, selected);
        const bool isAll = options->command.empty();
        const bool isKnown = isAll || std::ranges::find(allCommands(), options->command, &CommandInfo::name) != allCommands().end();
        if (!isKnown) return options->json.finish(session, {}, {unknownCommand(options->command)});
        if (!options->json.isStandardOutput())
            session.terminal.data(isAll ? program.help() : program.get_subcommand(options->command)->help(program.get_name()));
        return options->json.finish(session, describe(describeProgram(), options->command), {});
    };
}

}  // namespace lightcook::pipeline
