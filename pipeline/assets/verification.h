// What the verifications of all kinds of assets share.
#pragma once

#include <chrono>
#include <vector>

#include "pipeline/graph/action.h"
#include "verify/figures.h"
#include "verify/violation.h"

namespace lightcook::pipeline {

/// Wall time since it was made.
class Stopwatch {
public:
    double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// The limit that the asset is held to, of rel_rms.
double maxErrorOf(const ActionContext& context);

/// An outcome with the verdict on these stages; the last one bears the time since the watch was made.
ActionOutcome outcomeOf(std::vector<verify::StageError> stages, const ActionContext& context, const Stopwatch& watch,
                        const std::vector<verify::Violation>& violations);

}  // namespace lightcook::pipeline
