// Verdicts for continuous integration: JUnit XML for test panes, SARIF for annotations.
#pragma once

#include <string>

#include "pipeline/action.h"

namespace pipeline {

/// One test suite; a test case per asset and stage's asset verdict, errors that are no verdict as cases of their own.
std::string junitReport(const Json& report, const std::vector<formats::Error>& errors, const std::string& folder);
/// SARIF 2.1.0: one result per error.
std::string sarifReport(const std::vector<formats::Error>& errors);

}  // namespace pipeline
