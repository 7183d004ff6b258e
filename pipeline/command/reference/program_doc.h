// The command line as data, read from the CLI11 definitions of the commands: the source of the reference, the manual page and the shell
// completions.
#pragma once

#include <string>
#include <vector>

namespace CLI {  // NOLINT(readability-identifier-naming): name of the library
class Option;
}

namespace lightcook::pipeline {

struct OptionDoc {
    enum class Value { None, Choice, File, Folder, Other };

    std::vector<std::string> names;    ///< "-o", "--output"; of a positional one its name: "scene"
    std::string placeholder;           ///< "FILE", "0 to 9", "bc|astc|float"; empty for flags
    std::vector<std::string> choices;  ///< of Value::Choice
    std::string fallback;              ///< default value as text; empty: none, or named in the description
    std::string description;
    Value value = Value::None;
    bool isPositional = false, isRequired = false;
};

struct CommandDoc {
    std::string name, summary;
    std::string notes;  ///< paragraphs, and code whose lines begin with two spaces, separated by empty lines
    std::vector<OptionDoc> options;

    /// Returns "cook scene [options]".
    std::string usage() const;
};

struct ProgramDoc {
    std::string summary;
    std::vector<OptionDoc> options;  ///< of all commands
    std::vector<CommandDoc> commands;
};

/// Returns the description of one option.
OptionDoc describeOption(const CLI::Option& option);
/// Returns the description of the whole command line.
ProgramDoc describeProgram();

}  // namespace lightcook::pipeline
