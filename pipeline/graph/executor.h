// Runs a graph of actions: what is unchanged is taken from the cache, the rest is made, independent actions beside each other.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "formats/error.h"
#include "pipeline/graph/action.h"
#include "pipeline/graph/cache.h"
#include "pipeline/graph/digest.h"

namespace lightcook::pipeline {

struct ExecuteOptions {
    std::filesystem::path outputFolder;
    bool force = false;      ///< run everything, whatever the cache knows
    bool keepGoing = false;  ///< after a failure do what does not depend on it
};

struct ExecutionResult {
    std::map<std::string, ActionRecord> records;  ///< by action id, of those that succeeded
    std::vector<formats::Error> errors;           ///< in the order of the graph; the first decides the exit code
    int actionsRun = 0, actionsReused = 0;
    std::map<std::string, double> reused;  ///< by action id: the seconds that running it took last time
    std::vector<FileRecord> files;         ///< all that the graph made; those not in place yet lie in the staging folder
    /// Another graph's result, executed after this one into the same folders.
    void add(ExecutionResult later);
};

/// Order: an action's dependencies stand before it. Threads: those of the current tbb arena.
/// Files that are new or changed end up in `staging` under their names; publish() moves them. What already lies in the output folder
/// unchanged stays.
ExecutionResult execute(const std::vector<Action>& graph, const ExecuteOptions& options, const std::filesystem::path& staging,
                        const Cache& cache, DigestMemo& digests, const RunState& state);

/// Moves what execute() staged into the output folder.
formats::Result<void> publish(const ExecutionResult& result, const std::filesystem::path& staging,
                              const std::filesystem::path& outputFolder);

}  // namespace lightcook::pipeline
