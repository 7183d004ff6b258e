// Helpers that the verifications of all asset kinds share.
#pragma once

#include <chrono>
#include <vector>

#include "pipeline/assets/light_map/shading.h"
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

/// Parameters of verifications that judge visible errors. A folder of an older version has neither: the usual display and no limit.
struct VisibleParameters {
    std::optional<lighting::DisplaySettings> display;
    std::optional<double> maxVisible;            ///< limit on their 99th percentile
    std::optional<double> maxVisibleBound = {};  ///< limit on their proven bound

    /// Returns the display of light with a key.
    /// bt2020FromWorking  linear BT.2020 from the working primaries
    verify::Viewing viewing(double key, const glm::dmat3& bt2020FromWorking) const;
};
template <class Fields, Is<VisibleParameters> Self>
void describe(Fields& fields, Self& visible) {
    fields.optional("display", visible.display, "display that visible errors are judged on");
    fields.optional("max_visible", visible.maxVisible, "limit on the 99th percentile of visible errors");
    fields.optional("max_visible_bound", visible.maxVisibleBound, "limit on the proven bound of visible errors");
}

/// Returns the limit on rel_rms that the asset is held to: parameter "max_error" of its verify action, else kNoErrorLimit.
formats::Result<double> maxErrorOf(const ActionContext& context);

/// Returns a result with the verdict on these stages. The last stage gets the time since the watch was made.
VerifyResult judged(std::vector<verify::StageError> stages, double maxError, const Stopwatch& watch,
                    std::vector<verify::Violation> violations, const std::optional<double>& maxVisible = std::nullopt,
                    const std::optional<double>& maxVisibleBound = std::nullopt);

}  // namespace lightcook::pipeline
