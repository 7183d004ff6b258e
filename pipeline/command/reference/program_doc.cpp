#include "pipeline/command/reference/program_doc.h"

#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>

#include "pipeline/command/command.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/command/session.h"

namespace lightcook::pipeline {
namespace {

/// Returns the elements of "{a,b,c}".
std::vector<std::string> splitChoices(const std::string& braces) {
    std::vector<std::string> choices(1);
    for (const char c : braces.substr(1, braces.size() - 2))
        if (c == ',')
            choices.emplace_back();
        else
            choices.back() += c;
    return choices;
}

/// Derives the kind of an option's value from CLI11's type name: "TEXT:{a,b}", "INT:INT in [0 - 9]", "FLOAT:POSITIVE" or "FILE".
void describeValue(const std::string& type, OptionDoc& option) {
    const std::size_t colon = type.find(':');
    const std::string name = type.substr(0, colon), check = colon == std::string::npos ? "" : type.substr(colon + 1);
    option.value = OptionDoc::Value::Other;
    option.placeholder = name;
    if (name == kFilePlaceholder) option.value = OptionDoc::Value::File;
    if (name == kFolderPlaceholder) option.value = OptionDoc::Value::Folder;
    if (check.starts_with('{') && check.ends_with('}')) {
        option.value = OptionDoc::Value::Choice;
        option.choices = splitChoices(check);
        option.placeholder = fmt::format("{}", fmt::join(option.choices, "|"));
    } else if (const std::size_t range = check.find(" in ["); range != std::string::npos) {
        const std::string bounds = check.substr(range + 5, check.size() - range - 6);
        const std::size_t dash = bounds.find(" - ");
        option.placeholder = bounds.substr(0, dash) + " to " + bounds.substr(dash + 3);
    }
    if (option.placeholder == "FLOAT" || option.placeholder == "INT" || option.placeholder == "UINT") option.placeholder = "N";
}

std::vector<OptionDoc> describeOptions(const CLI::App& app) {
    std::vector<OptionDoc> options;
    for (const CLI::Option* option : app.get_options())
        if (option != app.get_help_ptr() || app.get_parent() == nullptr) options.push_back(describeOption(*option));
    return options;
}

}  // namespace

OptionDoc describeOption(const CLI::Option& option) {
    OptionDoc doc;
    doc.description = option.get_description();
    doc.fallback = option.get_default_str();
    doc.isPositional = option.get_positional();
    doc.isRequired = option.get_required();
    for (const std::string& name : option.get_snames()) doc.names.push_back("-" + name);
    for (const std::string& name : option.get_lnames()) doc.names.push_back("--" + name);
    if (doc.isPositional) doc.names = {option.get_name()};
    if (option.get_items_expected_max() > 0) describeValue(option.get_type_name(), doc);
    return doc;
}

std::string CommandDoc::usage() const {
    std::string text = name;
    bool hasOptions = false;
    for (const OptionDoc& option : options) {
        if (option.isPositional) text += " " + option.names.front();
        hasOptions = hasOptions || !option.isPositional;
    }
    return hasOptions ? text + " [options]" : text;
}

ProgramDoc describeProgram() {
    CLI::App app;
    GlobalOptions global;
    CommandFunction selected;
    defineProgram(app, global, selected);
    ProgramDoc program;
    program.summary = app.get_description();
    program.options = describeOptions(app);
    for (const CommandInfo& command : allCommands()) {
        const CLI::App& sub = *app.get_subcommand(std::string(command.name));
        program.commands.push_back({std::string(command.name), std::string(command.summary), sub.get_footer(), describeOptions(sub)});
    }
    return program;
}

}  // namespace lightcook::pipeline
