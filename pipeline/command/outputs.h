// Outputs of a command beside its result: JSON for scripts, JUnit and SARIF for continuous integration. And the end of the commands that
// cook.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "formats/error.h"
#include "pipeline/command/option_groups.h"
#include "pipeline/cook/cook.h"

namespace CLI {  // NOLINT(readability-identifier-naming): name of the library
class App;
}

namespace lightcook::pipeline {

class Session;
class Terminal;

/// Words in errors for a file that a cook wrote.
inline constexpr const char* kCookedFile = "one of the cooked folder";

/// The paths of a command line. A command may not write over what it reads, nor two outputs into one place.
///
/// Options that a command writes are declared so (declareWritten); all others with a path are read. Paths are the same if their
/// canonical forms are, or if they are links to one file. Standard output and devices are not compared.
class CommandPaths {
public:
    /// Returns the paths that were given to a parsed command.
    static CommandPaths of(CLI::App& command);
    bool hasOutputs() const { return !outputs_.empty(); }
    /// Fails if a path begins with "~" or an input has '\\' between folders (document/written_path.h), or if an output
    ///   - is an input, another output, or a file of a cooked folder of the command line; a report may replace that of its folder
    ///   - is a source of a cooked folder that is read
    ///   - lies below a file
    ///   - is a file and has the name of a folder, or is a folder and is named like a file
    formats::Result<void> check() const;
    /// Fails if an output is one of these inputs, which the command line does not name.
    /// what   "an input of the scene"
    formats::Result<void> checkAgainst(const std::vector<std::filesystem::path>& inputs, const std::string& what);
    /// The same for the files that a scene names, and for the files of the folder that it is cooked to (empty: none).
    formats::Result<void> checkAgainstScene(const Scene& scene, const std::filesystem::path& cooked);
    /// Returns true after checkAgainst() or checkAgainstScene() failed: then nothing may be written, not even the JSON of the error.
    bool isRefused() const { return isRefused_; }

private:
    struct Path {
        std::string name;  ///< "--json", "output"
        std::filesystem::path path;
        Written written = Written::No;
    };
    formats::Result<void> check(const Path& output) const;
    tl::unexpected<formats::Error> refuse(tl::unexpected<formats::Error> error) {
        isRefused_ = true;
        return error;
    }
    formats::Result<void> checkCooked(const Path& output, const std::filesystem::path& folder) const;
    /// Returns true if an output is the report of a cooked folder itself, or its page.
    bool isReportOf(const Path& output, const std::filesystem::path& folder) const;
    /// The same for the scene file and the sources of a cooked folder, where its manifest says and in that of --sources.
    formats::Result<void> checkSources(const Path& output, const std::filesystem::path& folder) const;

    std::vector<Path> inputs_, outputs_;
    bool isCook_ = false, isReport_ = false;  ///< the command cooks into its folder; its --json is the report of that folder
    bool isRefused_ = false;
};

/// Refuses "-" for a file that cannot be standard output: it would be a file of that name.
formats::Result<void> checkIsFile(const char* option, const std::filesystem::path& file);

/// Refuses an output folder that does not exist and ends like a file ("room.png"): another output was meant.
/// otherwise   what the command also writes: "or a .ktx2 file"; empty: nothing
formats::Result<void> checkFolderName(const std::filesystem::path& folder, const std::string& otherwise = "");

/// The missing folders above an output file, made for it. Those that are still empty at the end are removed: a command that fails leaves
/// none.
class FoldersOfFile {
public:
    static formats::Result<FoldersOfFile> make(const std::filesystem::path& file);
    ~FoldersOfFile();
    FoldersOfFile(FoldersOfFile&& other) noexcept = default;
    FoldersOfFile& operator=(FoldersOfFile&&) = delete;

private:
    explicit FoldersOfFile(std::vector<std::filesystem::path> made) : made_(std::move(made)) {}
    std::vector<std::filesystem::path> made_;  ///< the innermost first
};

/// The file of --json, which every command has. "-" is standard output; then lines for people go to standard error.
class JsonOutput {
public:
    /// what   "the report", for the help text
    void add(CLI::App& app, const std::string& what);

    /// Keeps standard output for the JSON if it goes there. Call before the command prints anything.
    void prepare(Session& session) const;

    /// Writes the facts that the command found. If it failed, the JSON has "passed" (false), "exit_code" and "errors" too.
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
    /// Writes the files. Returns the errors of the outcomes, and those of files that could not be written.
    /// command     "verify"
    /// outcomes    of one scene, or of its targets: then the JSON is that of `report` of several folders, and errors name their target
    /// sceneFile   empty: the one that the manifest names
    std::vector<formats::Error> write(Session& session, const std::string& command, const std::vector<Outcome>& outcomes,
                                      const std::filesystem::path& sceneFile, const std::filesystem::path& sources) const;

private:
    JsonOutput json_;
    std::filesystem::path junit_, sarif_;
};

/// The files of --json, --junit and --sarif of a command that fails before it comes to write them: no older file says that all is well.
class FailureDocuments {
public:
    /// Returns the documents that a parsed command line asks for.
    static FailureDocuments of(CLI::App& command);
    void write(const std::vector<formats::Error>& errors, Terminal& terminal) const;

private:
    std::string textOf(const std::string& option, const std::vector<formats::Error>& errors) const;

    std::string command_;
    std::filesystem::path input_;                                       ///< first argument: the scene file, or the folder of verify
    std::vector<std::pair<std::string, std::filesystem::path>> files_;  ///< with their options
};

/// Leaves what lint found of the inputs of several targets at the first target that has it.
void keepFindingsOnce(std::vector<Outcome>& outcomes);
/// Prints the result of a cook: warnings; on a terminal a table, then a line with the verdict, sizes and what came from the cache.
/// Quiet: warnings only. Call it after the documents were written, with the errors of that: they decide the verdict.
void printCook(Session& session, const Outcome& outcome);
/// Writes the JSON of a cook, prints the result and returns the exit code.
int finishCook(Session& session, const JsonOutput& json, Outcome outcome);

}  // namespace lightcook::pipeline
