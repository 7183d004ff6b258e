// A job: one action with everything that its result depends on, for a node of a cluster. `cook --launcher` writes it into a cache, and
// `lightcook work` on the node reads, runs and answers it.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "formats/error.h"
#include "pipeline/graph/action.h"
#include "pipeline/graph/remote_cache.h"

namespace lightcook::pipeline {

/// What has to be the same on all machines of a cluster.
struct ProgramIdentity {
    std::string version, sources, compiler;
    bool operator==(const ProgramIdentity&) const = default;
};
ProgramIdentity thisProgram();

/// An input of the action. Its content's name is its path on the machine that wrote the job.
struct JobInput {
    std::string role;
    std::string absolute;  ///< path without links of its own, below which the node keeps the content: files beside it stay beside it
    SharedContent content;
};

struct Job {
    ProgramIdentity program = {};
    std::string key;     ///< of the action
    bool force = false;  ///< whatever the node's cache has
    Action action = {};  ///< without inputs
    std::vector<JobInput> inputs = {};
    std::vector<ActionRecord> upstream = {};  ///< of the dependencies, in their order
    std::vector<SharedContent> files = {};    ///< of these records
};

std::string textOfJob(const Job& job);
/// Reads a job. Refuses one of another version of the program, by the name of this machine.
formats::Result<Job> readJob(const std::string& text, const std::string& machine);

}  // namespace lightcook::pipeline
