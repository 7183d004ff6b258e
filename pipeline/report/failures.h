// The failures of an asset's verification: for error lines, JUnit, SARIF and report.json.
#pragma once

#include <string>
#include <vector>

#include "formats/error.h"
#include "pipeline/document/json.h"
#include "pipeline/report/frontier.h"
#include "pipeline/report/report_row.h"

namespace lightcook::pipeline {

/// Returns the failures of an asset, in this order: its violations; each stage and kind of shading that is over the limit or not finite;
/// and its worst seam, if that is over its limit.
/// The text of a failure names the key of its limit, or the option of the command that converted the asset.
/// lightMap  that a dominant light belongs to, for the advice; may be null
/// frontier  see addFailures()
std::vector<Failure> failuresOf(const ReportRow& row, LimitsFrom limitsFrom, const ReportRow* lightMap = nullptr,
                                const std::vector<FrontierPoint>& frontier = {});

/// Gives the rows that did not pass their failures, those that have none yet. Call when all else in the rows is there.
/// frontier  of a scene whose budget chose the layouts: a limit on the whole that it does not allow is told with the budget that does
void addFailures(std::vector<ReportRow>& rows, LimitsFrom limitsFrom, const std::vector<FrontierPoint>& frontier = {});

/// Returns a place of report.json ("sampled_at", "bound_at", "at") as text: "texel (12, 31), green, normal (0, 0, 1)". Leaves out members
/// that are absent or of another type.
std::string placeWords(const Json& at);

/// Returns a list of numbers as "(1, 2.5, 3)"; empty for another value.
std::string vectorWords(const Json& v);

/// Returns the place, the steps, the light and, between two light maps, their names as text.
std::string seamWords(const SeamPlace& seam);

/// Returns one error of code OverLimit for each failure, in the same order.
std::vector<formats::Error> errorsOf(const std::vector<Failure>& failures);

}  // namespace lightcook::pipeline
