// The graph of actions. An action is a pure function of files and parameters. The graph is data: it is run here, or written for a build
// system.
#pragma once

#include <array>
#include <atomic>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "formats/error.h"
#include "pipeline/document/json.h"
#include "pipeline/graph/shared_objects.h"

namespace lightcook::pipeline {

/// A pure function of the content of its inputs, its parameters and its dependencies.
struct Action {
    std::string id;     ///< "cook/lightmap": unique in the graph
    std::string kind;   ///< names the function: "light-map", "verify-light-map", ...
    std::string asset;  ///< the asset that it belongs to, for messages, reports and --only
    Json parameters;
    std::map<std::string, std::filesystem::path> inputs;  ///< files by role: the user's, or a bake and mesh that were packed
    std::vector<std::string> dependencies;                ///< ids of the actions whose files and results this one reads
};

struct FileRecord {
    std::string name;  ///< relative to the output folder
    std::string digest;
    std::uint64_t bytes = 0;
};

/// Result of an action, kept in the cache under the action's key.
struct ActionRecord {
    std::string id;
    Json result;  ///< manifest entry, figures, counts: see assets/results.h
    std::vector<FileRecord> files;
    double seconds = 0;              ///< of its last run
    std::string run = {};            ///< RunRecord::at of the run that made it
    std::uint64_t peakRssBytes = 0;  ///< of a process that ran this action alone; 0: it was not measured
};

/// Events of an action while its graph runs. Each action of a graph is Planned before the first one is Started.
enum class ActionEvent { Planned, Started, Finished, Reused, Failed };

/// Progress and interrupt, shared by everything that runs in one cook. The functions may be empty, and are called from any thread.
struct RunState {
    std::atomic<bool> interrupted{false};
    /// A pass of an action: "encode lightmap", and the fraction of it that is done.
    std::function<void(const Action& action, const std::string& what, double fraction)> progress;
    /// seconds   of the action's run, or of its last one if it is Reused; else 0
    std::function<void(const Action& action, ActionEvent event, double seconds)> event;
    /// A fault that the run goes on with. May be called again with the same subject: only the first call is for the user.
    std::function<void(const std::string& subject, const std::string& detail)> warning;
    /// Fails if one of the files that a cook is about to put into its folder may not be written: the command writes something else there.
    std::function<formats::Result<void>(const std::vector<std::filesystem::path>& files)> checkOutputs;
};

class PartCache;

/// Context of a running action.
struct ActionContext {
    const Action& action;
    std::filesystem::path folder;               ///< where it writes its files
    std::filesystem::path upstreamFolder;       ///< where the files of its dependencies lie
    std::vector<const ActionRecord*> upstream;  ///< in the order of action.dependencies
    SharedObjects& shared;                      ///< shared with the actions beside it
    const RunState& state;
    std::array<double, 2> part = {0, 1};  ///< of the action that its passes are: from, to
    const PartCache* parts = nullptr;     ///< of results; null: none are kept

    /// Returns the context of passes that take this part of the time of those of this one.
    ActionContext between(double from, double to) const {
        ActionContext context = *this;
        const double length = part[1] - part[0];
        context.part = {part[0] + from * length, part[0] + to * length};
        return context;
    }
    /// Reports how far a pass is.
    void report(const std::string& what, double fraction) const {
        if (state.progress) state.progress(action, what, part[0] + fraction * (part[1] - part[0]));
    }
};
struct ActionOutcome {
    Json result = Json::object();
    std::vector<std::string> files;  ///< names, relative to the folder
};
using ActionFunction = formats::Result<ActionOutcome> (*)(const ActionContext&);

/// Returns the function of an action kind.
using ActionTable = ActionFunction (*)(const std::string& kind);

}  // namespace lightcook::pipeline
