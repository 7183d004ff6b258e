// Runs a job (job.h) on a node of a cluster.
#pragma once

#include <string>

#include "formats/error.h"
#include "pipeline/graph/action.h"
#include "pipeline/graph/cache.h"
#include "pipeline/graph/remote_cache.h"

namespace lightcook::pipeline {

/// Runs a job, leaves its result in the caches, and returns the id of its action. An error names files as the machine does that wrote the
/// job. job      its SHA-256 remote   has the job and its contents, and gets the result; null: `cache` does
formats::Result<std::string> runJob(const std::string& job, ActionTable functions, const Cache& cache, RemoteCache* remote,
                                    const RunState& state);

/// Keeps the place of a node after a failure if its cache folder takes no file: it would fail all actions of a cook within seconds. Call
/// once the error is stated: the cook then launches the action again, on another node.
void holdIfFull(const Cache& cache, const RunState& state);

}  // namespace lightcook::pipeline
