// Helpers that the verifications of all asset kinds share.
#pragma once

#include <chrono>
#include <vector>

#include "pipeline/assets/results.h"
#include "pipeline/graph/action.h"
#include "verify/figures.h"
#include "verify/violation.h"

namespace lightcook::pipeline {

/// Measures wall time since its construction.
class Stopwatch {
public:
    double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// Returns the limit on rel_rms that the asset is held to: parameter "max_error" of its verify action.
formats::Result<double> maxErrorOf(const ActionContext& context);

/// Returns a result with the verdict on these stages. The last stage gets the time since the watch was made.
VerifyResult judged(std::vector<verify::StageError> stages, double maxError, const Stopwatch& watch,
                    std::vector<verify::Violation> violations, const std::optional<double>& maxVisible = std::nullopt,
                    const std::optional<double>& maxVisibleBound = std::nullopt);

}  // namespace lightcook::pipeline
