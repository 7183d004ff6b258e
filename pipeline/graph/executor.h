// Runs a graph of actions: unchanged ones come from the cache, independent ones run beside each other.
#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "formats/error.h"
#include "pipeline/graph/action.h"
#include "pipeline/graph/cache.h"
#include "pipeline/graph/digest.h"
#include "pipeline/graph/job.h"
#include "pipeline/graph/key_log.h"
#include "pipeline/graph/launcher.h"
#include "pipeline/graph/remote_cache.h"
#include "pipeline/graph/trace.h"

namespace lightcook::pipeline {

struct ExecuteOptions {
    std::filesystem::path outputFolder;
    bool force = false;      ///< run everything, whatever the cache has
    bool keepGoing = false;  ///< after a failure, run the actions that do not depend on it
    /// Why the output folder cannot be written, if it cannot. Then an action fails with this error unless the cache has its result and all
    /// of its files are in the output folder.
    std::optional<formats::Error> unwritable = {};
};

struct ExecutionResult {
    std::map<std::string, ActionRecord> records;  ///< by action id, of those that succeeded
    std::vector<formats::Error> errors;           ///< in the order of the graph; the first decides the exit code
    int actionsRun = 0, actionsReused = 0;
    std::map<std::string, double> reused;  ///< by action id: seconds of its last run
    std::vector<FileRecord> files;         ///< made by the graph; new ones lie in the staging folder
    /// Adds the result of another graph that ran after this one into the same folders.
    void add(ExecutionResult later);
};

/// Returns true if a job ends at these errors: at any without --keep-going, and at all once it was interrupted.
inline bool isEndedBy(const std::vector<formats::Error>& errors, bool keepGoing, const RunState& state) {
    return !errors.empty() && (!keepGoing || state.interrupted);
}

/// Services that the actions of a graph run with.
struct ExecutionContext {
    ActionTable functions;
    const Cache& cache;
    DigestMemo& digests;
    const RunState& state;
    std::string run = {};                              ///< RunRecord::at of this run
    SharedObjects* shared = nullptr;                   ///< of several graphs that run one after another; none: this graph has its own
    KeyLog* keys = nullptr;                            ///< of the output folder; none: nothing is explained
    RemoteCache* remote = nullptr;                     ///< asked for what `cache` does not have; none: there is none
    Trace* trace = nullptr;                            ///< none: nothing is traced
    Launcher* launcher = nullptr;                      ///< of actions that take long, on other machines; none: all run here
    std::vector<const ExecutionResult*> earlier = {};  ///< of graphs that ran before this one into the same folders
};

/// Runs a graph, on the threads of the current TBB arena. The dependencies of an action stand before it, or are of an earlier graph;
/// without their results it does not run. New and changed files end up in `staging` under their names; publish() moves them. Unchanged
/// files stay in the output folder.
ExecutionResult execute(const std::vector<Action>& graph, const ExecuteOptions& options, const std::filesystem::path& staging,
                        const ExecutionContext& context);

/// Runs one action on a node, or takes its result from the cache. Its record has the memory of this process.
/// action   that of the job, with the inputs of this machine
/// options  the output folder has the files of the dependencies, and gets those of the action
formats::Result<ActionRecord> executeJob(const Job& job, const Action& action, const ExecuteOptions& options,
                                         const ExecutionContext& context);

/// Moves the files that execute() staged into the output folder.
formats::Result<void> publish(const ExecutionResult& result, const std::filesystem::path& staging,
                              const std::filesystem::path& outputFolder);

}  // namespace lightcook::pipeline
