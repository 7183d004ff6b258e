// The errors of a report that decide the exit code, and cooked folders as `lightcook report` reads them.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "formats/error.h"
#include "pipeline/report/collection.h"
#include "pipeline/report/report.h"

namespace lightcook::pipeline {

/// Appends an error for each action that failed in the cook, if it is not there yet, then one for each failure of an asset, and one if the
/// budget is exceeded.
/// budgetPlace  file or option that the budget is of
void appendErrorsOf(const Report& report, const formats::Subject& budgetPlace, std::vector<formats::Error>& errors);

/// Returns the place of the budget of a cooked folder: its report, which keeps it.
formats::Subject budgetPlace(const std::filesystem::path& folder);

/// Reads the report of a cooked folder, with the errors of its cook and of files that were changed since. Fails without a manifest or a
/// report that can be read.
formats::Result<CookedFolder> readCookedFolder(const std::filesystem::path& folder);

}  // namespace lightcook::pipeline
