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

/// Parameters of verifications that judge visible errors.
struct VisibleParameters {
    std::optional<lighting::DisplaySettings> display;
    Limits limits;

    /// Returns the display of light with a key.
    /// bt2020FromWorking  linear BT.2020 from the working primaries
    verify::Viewing viewing(double key, const glm::dmat3& bt2020FromWorking) const;
};
template <class Fields, Is<VisibleParameters> Self>
void describe(Fields& fields, Self& visible) {
    fields.optional("display", visible.display, "display that visible errors are judged on");
    describe(fields, visible.limits, kAssetLimits);
}

/// Returns true if the verdict so far passed, and a result keeps its limits: its last stage, every mip level and mix of two, and its seams.
bool passes(const VerifyResult& result);

/// Returns a result with the verdict on these stages. The last stage gets the time since the watch was made. Without a limit on rel_rms it
/// is held to kNoErrorLimit.
VerifyResult judged(std::vector<verify::StageError> stages, Limits limits, const Stopwatch& watch,
                    std::vector<verify::Violation> violations);

}  // namespace lightcook::pipeline
