// Runs actions on other machines: a command of the user's, such as `srun`, is put before `lightcook work JOB`.
//
// The cache carries. The job (job.h), inputs and files of dependencies are contents of the remote cache, or of a cache folder that all
// machines see. The node writes the result there, as every cook does. An action is done once its record is in the cache and each of its
// outputs has its digest, whatever the command returned: srun has returned 0 for a step that had not ended. Until then it is launched
// again, kMostLaunches times in all, and contents are written anew. A launch that ended without a word may have lacked memory or time: the
// next one asks for twice as much. An error that the node states about the inputs, the request or its version of the program ends the
// action. One about the node itself does not; the node then keeps its place for a while, so that the next launch goes to another one.
//
// A launch costs 0.2 s, and 0.4 s where all cores are busy. An action that is predicted to take less than kLeastSeconds runs here, so that
// the cost stays below a twentieth.
#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "formats/error.h"
#include "pipeline/graph/action.h"
#include "pipeline/graph/cache.h"
#include "pipeline/graph/digest.h"
#include "pipeline/graph/job.h"
#include "pipeline/graph/remote_cache.h"
#include "pipeline/graph/trace.h"
#include "pipeline/graph/work_rates.h"

namespace lightcook::pipeline {

struct LaunchOptions {
    std::string command;                  ///< put before the program; {memory} is replaced by MiB, {time} by minutes
    std::filesystem::path program;        ///< on the nodes
    std::vector<std::string> words = {};  ///< options of `work`
    /// Returns the error that a node has stated in what the command printed; nothing if it states none.
    std::function<std::optional<formats::Error>(const std::string& output)> statedError = {};
};

/// Time and memory that an action is expected to take.
struct Prediction {
    double seconds = 0, bytes = 0;
};

/// Returns the launcher with its placeholders filled in: four times the time, at least kLeastMinutes, and 1.5 times the memory.
std::string filledLauncher(const std::string& command, const Prediction& prediction);

/// An action that is about to be launched.
struct Launch {
    const Action& action;
    const std::vector<const ActionRecord*>& upstream;
    const std::string& key;
    bool force;
    const std::filesystem::path& folder;  ///< has the files of the dependencies, and inputs that the cook made
    DigestMemo& digests;
    const RunState& state;
    std::function<bool()> isDone;  ///< takes the result out of the cache
};

/// May be used from several threads.
class Launcher {
public:
    static constexpr int kMostLaunches = 5;
    static constexpr double kLeastSeconds = 10;

    /// remote  null: the machines share the folder of the cache
    /// trace   may be null
    Launcher(LaunchOptions options, const Cache& cache, RemoteCache* remote, Trace* trace);

    /// Returns true if the action takes long enough.
    bool takes(const Action& action, const std::vector<const ActionRecord*>& upstream) const;
    Prediction predict(const Action& action, const std::vector<const ActionRecord*>& upstream) const;
    /// Launches the action until it is done.
    formats::Result<void> launch(const Launch& launch);
    /// Learns from a result, wherever it was made.
    void learn(const Action& action, const std::vector<const ActionRecord*>& upstream, const ActionRecord& record);
    /// Writes what it has learnt.
    void save() const;

private:
    formats::Result<std::string> writeJob(const Launch& launch, bool replace);
    formats::Result<std::string> sha256Of(const std::string& digest, const std::filesystem::path& file);

    LaunchOptions options_;
    const Cache& cache_;
    RemoteCache* remote_;
    Trace* trace_;
    mutable std::mutex mutex_;
    WorkRates seconds_, memory_;                 ///< by kind of action, and by kind and asset
    std::map<std::string, std::string> sha256_;  ///< by the other digest
};

}  // namespace lightcook::pipeline
