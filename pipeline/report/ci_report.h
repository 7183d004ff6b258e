// Verdicts for continuous integration: JUnit XML for test panes, SARIF for annotations.
#pragma once

#include <string>

#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// Returns one test suite. Each asset is a test case, and each error is a failed test case of its own, with asset, stage, texel, normal,
/// found and allowed as its properties (failures.h).
std::string junitReport(const Json& report, const std::vector<formats::Error>& errors, const std::string& folder);
/// Returns SARIF 2.1.0: one result for each error, with the same properties and the asset and stage as its logical location.
std::string sarifReport(const Json& report, const std::vector<formats::Error>& errors);

}  // namespace lightcook::pipeline
