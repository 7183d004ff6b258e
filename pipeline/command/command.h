// The commands of the program: one row of kCommands and one file each. Help, documentation and shell completions derive from them.
//
// A new command is a file with a function `CommandFunction defineX(CLI::App&)`, which adds the options and returns the function
// to run once they are parsed, and a row in command.cpp.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "formats/error.h"
#include "pipeline/command/outputs.h"

namespace CLI {  // NOLINT(readability-identifier-naming): name of the library
class App;
}

namespace lightcook::pipeline {

class Session;
struct GlobalOptions;

/// Runs a command whose options are parsed; returns the exit code.
using CommandFunction = std::function<int(Session&)>;

/// Uses that a command makes of a cooked folder, besides reading it.
enum class FolderUse {
    None,
    Cooks,           ///< writes one
    Reports,         ///< its --json may take the place of the report in that folder
    CooksAndReports  ///< writes one, with its --json as the report
};

struct CommandInfo {
    std::string_view name;
    std::string_view summary;                  ///< one line for `--help` and the reference
    CommandFunction (*define)(CLI::App& app);  ///< adds the command's options to its subcommand
    FolderUse folder = FolderUse::None;
};

/// Returns every command, in the order of `--help`.
std::span<const CommandInfo> allCommands();

/// Adds the global options and all commands to `app`. Parsing then sets `global`, and `selected` to the function of the command.
void defineProgram(CLI::App& app, GlobalOptions& global, CommandFunction& selected);

/// Returns the error of a name that no command has, with the nearest one.
formats::Error unknownCommand(const std::string& name);

/// Returns the function of the command that the arguments name; with an exit code instead where there is nothing to run: after
/// --help or --version (0), or after a mistake (2), which is then printed. A mistake on the command line is in no document.
struct ParsedCommandLine {
    CommandFunction function;
    int exitCode = 0;
    FailureDocuments documents;  ///< that the command writes if it fails
};
ParsedCommandLine parseCommandLine(int argc, const char* const* argv, GlobalOptions& global);

}  // namespace lightcook::pipeline
