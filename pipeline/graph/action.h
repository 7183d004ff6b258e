// The graph of actions: what has to be made, from what, by which pure function. The graph is data; run here, or written for others.
#pragma once

#include <atomic>
#include <filesystem>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "formats/error.h"

namespace lightcook::pipeline {

using Json = nlohmann::ordered_json;  ///< keys keep the order in which a reader wants to see them

/// A pure function of its inputs' content and its parameters.
struct Action {
    std::string id;     ///< "cook/lightmap": unique in the graph
    std::string kind;   ///< which function: "light-map", "verify-light-map", ...
    std::string asset;  ///< the asset that it belongs to, for messages, reports and --only
    Json parameters;
    std::map<std::string, std::filesystem::path> inputs;  ///< by role: files of the user's
    std::vector<std::string> dependencies;                ///< ids of actions whose files and results this one reads
};

struct FileRecord {
    std::string name;  ///< relative to the output folder
    std::string digest;
    std::uint64_t bytes = 0;
};

/// What an action left: kept in the cache under the action's key.
struct ActionRecord {
    std::string id;
    Json result;  ///< small facts: manifest entries, figures, counts
    std::vector<FileRecord> files;
    double seconds = 0;  ///< when it last ran

    Json toJson() const;
    static formats::Result<ActionRecord> fromJson(const Json& json, const std::string& subject);
};

/// How far things are and whether to stop; shared by everything that runs in one cook.
struct RunState {
    std::atomic<bool> interrupted{false};
    std::function<void(const std::string& what, double fraction)> progress;  ///< may be empty; called from any thread
};

class LightMapSources;

/// What a running action sees.
struct ActionContext {
    const Action& action;
    std::filesystem::path folder;               ///< where it writes its files
    std::filesystem::path upstreamFolder;       ///< where the files of its dependencies lie
    std::vector<const ActionRecord*> upstream;  ///< in the order of action.dependencies
    LightMapSources& lightMaps;                 ///< open light maps, shared with the actions beside it
    const RunState& state;
};
struct ActionOutcome {
    Json result = Json::object();
    std::vector<std::string> files;  ///< names, relative to the folder
};
using ActionFunction = formats::Result<ActionOutcome> (*)(const ActionContext&);

/// The function behind a kind; every kind that plan() names has one.
ActionFunction actionFunction(const std::string& kind);

}  // namespace lightcook::pipeline
