// The limit of an asset that it uses most of: rel_rms, visible error, proven bound, seams, or what a pixel shows with its dominant light.
#pragma once

#include <optional>
#include <string>

#include "pipeline/report/report_row.h"

namespace lightcook::pipeline {

/// A figure of an asset beside its limit.
struct LimitUse {
    double share = 0;   ///< of the limit; infinite for a figure that is not finite
    std::string words;  ///< "visible p99 1.04 of 1.1"
    std::string brief;  ///< "visible 1.04 of 1.1": after the key of the limit
};

/// Returns the use of the limit that an asset is nearest to or farthest over; of equal ones the first. Empty: it has no limit that a figure
/// stands beside.
std::optional<LimitUse> mostUsedLimit(const ReportRow& row);

}  // namespace lightcook::pipeline
