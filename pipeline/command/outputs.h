// Outputs of a command beside its result: JSON for scripts, JUnit and SARIF for continuous integration. And the end of the commands that
// cook.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/error.h"
#include "pipeline/cook/cook.h"

namespace CLI {  // NOLINT(readability-identifier-naming): name of the library
class App;
}

namespace lightcook::pipeline {

class Session;

/// The file of --json, which every command has. "-" is standard output; then lines for people go to standard error.
class JsonOutput {
public:
    /// what   "the report", for the help text
    void add(CLI::App& app, const std::string& what);

    /// Keeps standard output for the JSON if it goes there. Call before the command prints anything.
    void prepare(Session& session) const;

    /// Writes the facts that the command found. If it failed, the JSON has "exit_code" and "errors" too.
    formats::Result<void> write(Session& session, Json facts, const std::vector<formats::Error>& errors) const;

    /// Writes the JSON, prints the errors and returns the exit code.
    int finish(Session& session, Json facts, std::vector<formats::Error> errors) const;
    int finish(Session& session, const formats::Result<Json>& facts) const;

    bool isGiven() const { return !file_.empty(); }
    bool isStandardOutput() const;

private:
    std::filesystem::path file_;
};

/// The files of --json, --junit and --sarif.
class CiOutputs {
public:
    void add(CLI::App& app);
    /// Refuses two documents on standard output, and keeps it for the one that goes there.
    formats::Result<void> prepare(Session& session) const;
    /// Writes the files. Returns the errors of the outcome, and those of files that could not be written.
    /// command     "verify"
    /// sceneFile   empty: the one that the manifest names
    std::vector<formats::Error> write(Session& session, const std::string& command, const Outcome& outcome,
                                      const std::filesystem::path& sceneFile, const std::filesystem::path& sources) const;

private:
    JsonOutput json_;
    std::filesystem::path junit_, sarif_;
};

/// Prints the result of a cook: warnings of lint; on a terminal a table, then a line with the verdict, sizes and what came from the cache.
/// Quiet: warnings only.
void printCook(Session& session, const Outcome& outcome);

}  // namespace lightcook::pipeline
