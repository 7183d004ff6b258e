// Keys that the actions of an output folder had in its last run, so that a later run can say why an action runs again.
#pragma once

#include <filesystem>
#include <functional>
#include <mutex>
#include <string>

#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// Ways in which an action gets its result.
enum class ResultSource { Run, ForcedRun, LocalCache, RemoteCache };
constexpr bool isReused(ResultSource source) {
    return source == ResultSource::LocalCache || source == ResultSource::RemoteCache;
}
/// Receives why an action ran or did not. May be called from several threads.
using Explain = std::function<void(const Action& action, bool hasRun, const std::string& why)>;

/// May be used from several threads.
class KeyLog {
public:
    /// file      holds the keys of earlier runs; a missing or damaged one counts as empty
    /// explain   may be empty
    KeyLog(std::filesystem::path file, Explain explain);

    /// Explains an action by what differs from its last key: "parameter effort: 5 -> 7". Notes its key if it has its result.
    void add(const Action& action, Json key, ResultSource source, bool hasResult);
    /// Writes the log if it changed. One that cannot be written costs later explanations.
    void save() const;

private:
    std::string reason(const Action& action, const Json& key, ResultSource source) const;

    std::filesystem::path file_;
    Explain explain_;
    mutable std::mutex mutex_;
    Json keys_;  ///< by action id
};

}  // namespace lightcook::pipeline
