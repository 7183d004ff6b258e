// Verdicts for continuous integration: JUnit XML for test panes, SARIF for annotations.
#pragma once

#include <string>
#include <vector>

#include "pipeline/report/ci_checks.h"

namespace lightcook::pipeline {

/// Returns JUnit XML: for each run a suite for the scene and one for each asset, a case for each check. A check that failed is red itself
/// and has every finding with its facts; one that was not made is skipped. runs  of the targets of a scene
std::string junitReport(const std::vector<CiRun>& runs);
inline std::string junitReport(const CiRun& run) {
    return junitReport(std::vector<CiRun>{run});
}

/// Returns SARIF 2.1.0, a run for each: a rule for each check, and a result for each finding at its line of the scene file, with the asset
/// and stage as its logical location and the facts as its properties.
std::string sarifReport(const std::vector<CiRun>& runs);
inline std::string sarifReport(const CiRun& run) {
    return sarifReport(std::vector<CiRun>{run});
}

}  // namespace lightcook::pipeline
