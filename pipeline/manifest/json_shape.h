// Shape of report.json, before anything reads it.
#pragma once

#include <string>

#include "formats/error.h"
#include "pipeline/json/json.h"

namespace lightcook::pipeline {

/// Refuses a report with a member of a wrong type or range; the error names its place.
/// subject   the file, for the error
formats::Result<void> checkReport(const Json& report, const std::string& subject);

/// Returns the fields of report.json as a Markdown table.
std::string reportReference();

}  // namespace lightcook::pipeline
