// The errors of a report that decide the exit code.
#pragma once

#include <vector>

#include "formats/error.h"
#include "pipeline/report/report.h"

namespace lightcook::pipeline {

/// Appends an error for each failure of an asset, and one if the budget is exceeded.
void appendVerdicts(const Report& report, std::vector<formats::Error>& errors);

}  // namespace lightcook::pipeline
