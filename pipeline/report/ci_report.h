// Verdicts for continuous integration: JUnit XML for test panes, SARIF for annotations.
#pragma once

#include <string>

#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// One test suite; a test case per asset, and every error as a failed one of its own, whose properties tell asset, stage, texel, normal,
/// found and allowed (report_failures.h).
std::string junitReport(const Json& report, const std::vector<formats::Error>& errors, const std::string& folder);
/// SARIF 2.1.0: one result per error, with the same properties and the asset and stage as its logical location.
std::string sarifReport(const Json& report, const std::vector<formats::Error>& errors);

}  // namespace lightcook::pipeline
