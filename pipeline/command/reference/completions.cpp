#include "pipeline/command/reference/completions.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "pipeline/graph/shell_word.h"

namespace lightcook::pipeline {
namespace {

using Value = OptionDoc::Value;

std::string joined(const std::vector<std::string>& words, const char* separator = " ") {
    return fmt::format("{}", fmt::join(words, separator));
}

/// Returns the choices that are single words in every shell; those such as "sqrt(1 - NoV)" are not offered.
std::string wordsOf(const std::vector<std::string>& choices) {
    std::vector<std::string> words;
    for (const std::string& choice : choices)
        if (std::all_of(choice.begin(), choice.end(),
                        [](unsigned char c) { return std::isalnum(c) != 0 || c == '-' || c == '_' || c == '.'; }))
            words.push_back(choice);
    return joined(words);
}

std::vector<std::string> namesOf(const std::vector<OptionDoc>& options) {
    std::vector<std::string> names;
    for (const OptionDoc& option : options)
        if (!option.isPositional) names.insert(names.end(), option.names.begin(), option.names.end());
    return names;
}

std::vector<std::string> commandNames(const ProgramDoc& program) {
    std::vector<std::string> names;
    for (const CommandDoc& command : program.commands) names.push_back(command.name);
    return names;
}

// --- bash -----------------------------------------------------------------------------------------------------------------------------

/// Returns the cases of `case $previous` for the options that take a value.
std::string bashValueCases(const std::vector<OptionDoc>& options, const std::string& indent) {
    std::string text;
    for (const OptionDoc& option : options) {
        if (option.isPositional || option.value == Value::None) continue;
        std::string reply = "return 0";
        if (option.value == Value::Choice) reply = fmt::format("_lightcook_words {}; return 0", shellQuoted(wordsOf(option.choices)));
        if (option.value == Value::File) reply = "_lightcook_files -f; return 0";
        if (option.value == Value::Folder) reply = "_lightcook_files -d; return 0";
        text += fmt::format("{}{}) {} ;;\n", indent, joined(option.names, "|"), reply);
    }
    return text;
}

/// Returns a pattern of the global options that take a value: their values are no commands.
std::string globalValuePattern(const ProgramDoc& program) {
    std::vector<std::string> names;
    for (const OptionDoc& option : program.options)
        if (option.value != Value::None) names.insert(names.end(), option.names.begin(), option.names.end());
    return joined(names, "|");
}

// --- zsh ------------------------------------------------------------------------------------------------------------------------------

/// Escapes the characters that end a description of _arguments.
std::string zshDescription(const std::string& text) {
    std::string escaped;
    for (const char c : text) {
        if (c == '[' || c == ']' || c == ':' || c == '\\') escaped += '\\';
        escaped += c;
    }
    return escaped;
}

std::string zshAction(const OptionDoc& option) {
    switch (option.value) {
        case Value::Choice:
            return fmt::format("({})", wordsOf(option.choices));
        case Value::File:
            return "_files";
        case Value::Folder:
            return "_files -/";
        case Value::None:
        case Value::Other:
            break;
    }
    return " ";
}

std::string zshArguments(const std::vector<OptionDoc>& options) {
    std::string text;
    for (const OptionDoc& option : options) {
        if (option.isPositional) {
            text += fmt::format(" \\\n                {}", shellQuoted(fmt::format(":{}:{}", option.names.front(), zshAction(option))));
            continue;
        }
        for (const std::string& name : option.names) {
            std::string spec = fmt::format("{}[{}]", name, zshDescription(option.description));
            if (option.value != Value::None) spec += fmt::format(":value:{}", zshAction(option));
            text += fmt::format(" \\\n                {}", shellQuoted(spec));
        }
    }
    return text;
}

// --- fish -----------------------------------------------------------------------------------------------------------------------------

std::string fishQuoted(const std::string& text) {
    std::string result = "'";
    for (const char c : text) {
        if (c == '\'' || c == '\\') result += '\\';
        result += c;
    }
    return result + "'";
}

std::string fishOptions(const std::vector<OptionDoc>& options, const std::string& condition) {
    std::string text;
    for (const OptionDoc& option : options) {
        if (option.isPositional) continue;
        std::string line = "complete -c lightcook" + condition;
        for (const std::string& name : option.names) line += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
        if (option.value == Value::Choice) line += " -x -a " + fishQuoted(wordsOf(option.choices));
        if (option.value == Value::File) line += " -r -F";
        if (option.value == Value::Folder) line += " -x -a '(__fish_complete_directories)'";
        if (option.value == Value::Other) line += " -x";
        text += line + " -d " + fishQuoted(option.description) + "\n";
    }
    return text;
}

}  // namespace

std::string bashCompletion(const ProgramDoc& program) {
    std::string text = R"(# bash completion for lightcook. Generated from the program's command table.

_lightcook_words() {
    mapfile -t COMPREPLY < <(compgen -W "$1" -- "${COMP_WORDS[COMP_CWORD]}")
}

_lightcook_files() {
    compopt -o filenames 2>/dev/null
    mapfile -t COMPREPLY < <(compgen "$1" -- "${COMP_WORDS[COMP_CWORD]}")
}

_lightcook() {
    local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD-1]} command= i
    COMPREPLY=()
    for ((i = 1; i < COMP_CWORD; i++)); do
        case ${COMP_WORDS[i]} in
)";
    text += fmt::format("            {}) ((i++)) ;;\n", globalValuePattern(program));
    text += "            -*) ;;\n            *) command=${COMP_WORDS[i]}; break ;;\n        esac\n    done\n    case $previous in\n";
    text += bashValueCases(program.options, "        ");
    text += "    esac\n    local options=" + shellQuoted(joined(namesOf(program.options))) + "\n    case $command in\n";
    text += fmt::format("        '') [[ $current == -* ]] || options={} ;;\n", shellQuoted(joined(commandNames(program))));
    for (const CommandDoc& command : program.commands) {
        const std::string values = bashValueCases(command.options, "                ");
        text += fmt::format("        {})\n", command.name);
        if (!values.empty()) text += "            case $previous in\n" + values + "            esac\n";
        if (command.name == "help")  // its only argument is a command
            text += fmt::format("            [[ $current == -* ]] || {{ _lightcook_words {}; return 0; }}\n",
                                shellQuoted(joined(commandNames(program))));
        text += fmt::format("            options+={}\n            ;;\n", shellQuoted(fmt::format(" {}", joined(namesOf(command.options)))));
    }
    text += "    esac\n    if [[ -z $command || $current == -* ]]; then\n        _lightcook_words \"$options\"\n    else\n";
    text += "        _lightcook_files -f\n    fi\n}\n\ncomplete -F _lightcook lightcook\n";
    return text;
}

std::string zshCompletion(const ProgramDoc& program) {
    std::string text = "#compdef lightcook\n# zsh completion for lightcook. Generated from the program's command table.\n\n";
    text +=
        "_lightcook() {\n    local curcontext=\"$curcontext\" state line\n    typeset -A opt_args\n    local -a commands\n    commands=(\n";
    for (const CommandDoc& command : program.commands)
        text += fmt::format("        {}\n", shellQuoted(command.name + ":" + zshDescription(command.summary)));
    text += "    )\n    _arguments -C" + zshArguments(program.options);
    text += " \\\n                '1:command:->command' \\\n                '*::argument:->argument' && return\n";
    text +=
        "    case $state in\n        command) _describe -t commands command commands ;;\n        argument)\n            case $line[1] in\n";
    for (const CommandDoc& command : program.commands)
        text += fmt::format("                {}) _arguments{} ;;\n", command.name, zshArguments(command.options));
    text += "            esac\n            ;;\n    esac\n}\n\n_lightcook \"$@\"\n";
    return text;
}

std::string fishCompletion(const ProgramDoc& program) {
    std::string text = "# fish completion for lightcook. Generated from the program's command table.\n\n";
    text += fishOptions(program.options, "");
    const std::string none = fmt::format(" -n 'not __fish_seen_subcommand_from {}'", joined(commandNames(program)));
    for (const CommandDoc& command : program.commands)
        text += fmt::format("complete -c lightcook -f{} -a {} -d {}\n", none, command.name, fishQuoted(command.summary));
    for (const CommandDoc& command : program.commands)
        text += fishOptions(command.options, fmt::format(" -n '__fish_seen_subcommand_from {}'", command.name));
    return text;
}

}  // namespace lightcook::pipeline
