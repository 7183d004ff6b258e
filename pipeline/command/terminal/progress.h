// One line of progress for a whole job: actions that are done, stages that run, time left.
#pragma once

#include <chrono>
#include <map>
#include <mutex>
#include <set>
#include <string>

#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// Adds up the events of a graph. Callable from any thread.
class Progress {
public:
    void onEvent(const Action& action, ActionEvent event);
    /// Records how far a pass of an action is. An action without events, such as that of `dominant --report`, counts from its first pass.
    void onPass(const Action& action, const std::string& what, double fraction);

    /// Returns the done fraction of the job. It never decreases while no actions are added, and none runs again.
    double fraction() const;

    /// Returns "[######........]  43 %  5/12 encode lobby 70 %, verify probe0 12 %  0:14 left", at most `columns` long. While only actions
    /// are known that the plan of a cook needs, nobody knows how much there is to do: the line has no bar then.
    /// seconds   since the job began, at least those of the call before
    std::string line(double seconds, int columns);

private:
    struct Running {
        std::string what;
        double fraction = 0;
    };
    double fractionLocked() const;
    /// Counts an action that is done once more. What verifies an asset runs again after its cook.
    void repeatLocked(const std::string& id);
    std::string leftLocked(double seconds, double fraction);

    mutable std::mutex mutex_;
    std::map<std::string, double> weights_;  ///< by action id
    std::set<std::string> done_;
    std::map<std::string, Running> running_;
    bool isPlanned_ = false;    ///< an action is known that a plan does not need
    double repeatedWork_ = 0;   ///< of earlier runs of actions that run once more
    std::size_t repeated_ = 0;  ///< number of these runs
    double end_ = 0;            ///< expected, as shown [s since the job began]; 0: none was shown
};

/// Returns the expected time of an action on a common machine [s], by its kind and the size of its inputs: an estimate for the line of
/// progress, where only what actions take beside each other matters.
double workOf(const Action& action);

}  // namespace lightcook::pipeline
