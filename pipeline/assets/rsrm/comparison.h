// Errors of a reflection map: for its verification, and for the choice of its format.
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "pipeline/assets/rsrm/rsrm.h"
#include "pipeline/scene/rsrm_format.h"
#include "verify/rsrm.h"
#include "verify/violation.h"

namespace lightcook::pipeline {

/// Returns a map as the verifier reads it.
/// bytes  of its one image, `width` texels wide
verify::CookedRsrm decodedRsrm(const RsrmFormatInfo& format, bool isDithered, const RsrmConstants& constants,
                               std::span<const std::byte> bytes, int width);

/// Errors of a map. Stages and violations are those of the report.
struct RsrmComparison {
    std::vector<verify::RsrmRow> rows;
    std::vector<verify::StageError> stages;
    std::vector<verify::Violation> violations;
};
/// Compares a map with its source. Nothing after an interrupt.
/// what     for the progress
/// viewing  display for visible errors; empty: none
std::optional<RsrmComparison> compareRsrm(const verify::CookedRsrm& map, const verify::RsrmSource& source,
                                          const glm::vec3& luminanceWeights, const ActionContext& context, const std::string& what,
                                          const std::optional<verify::Viewing>& viewing = std::nullopt);

/// Errors that the choice of a format goes by.
struct RsrmFormatErrors {
    double relRms = 0;  ///< the larger one of diffuse and specular, of the whole map
    double p99 = 0;     ///< the same of local errors at texel centres, where the format alone counts
    bool isSound = true;
    /// Returns true if the verification will pass.
    bool passes(double limit) const { return isSound && relRms <= limit; }
    /// Returns true if p99 is within the limit too. A sun decides rel_rms, its sky p99.
    bool keeps(double limit) const { return passes(limit) && p99 <= limit; }
};
RsrmFormatErrors formatErrors(const RsrmComparison& comparison);

}  // namespace lightcook::pipeline
