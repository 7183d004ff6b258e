// Advice on the error of an asset and on a budget, from figures that the cook measured. Terminal, page, viewer, JUnit and SARIF show it
// under a failure, and reports beside the error of the whole shading. Advice that no figure supports is left out.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/report/frontier.h"
#include "pipeline/report/report_row.h"

namespace lightcook::pipeline {

/// Returns the rows of light maps.
std::vector<const ReportRow*> lightMapsOf(const std::vector<ReportRow>& rows);

/// Returns the row of the light map that a dominant light or a mesh belongs to: the one with the same bake; of several, the one whose name
/// theirs begins with. Null: there is none.
const ReportRow* lightMapOf(const ReportRow& row, const std::vector<const ReportRow*>& lightMaps);

/// Returns the remedy for the error of an asset: the key to write, what it gives and what it costs. Empty: none is known.
/// over      a figure that is over its limit, which the remedy is to bring back; none: any lower error helps
/// lightMap  that a dominant light belongs to; may be null
std::string remedyOf(const ReportRow& row, const std::optional<Check>& over, const ReportRow* lightMap);

/// Returns the advice under a figure over its limit: the cause if it is known, the remedy, and the value of the limit that allows it.
std::string adviceOn(const ReportRow& row, const Check& over, const ReportRow* lightMap);

/// Returns "A budget of 625 KiB keeps it (map: basis-4, dominant light derived). ", of the smallest scene that keeps a limit on the visible
/// error of the whole; empty: there is none.
std::string budgetRemedy(const std::vector<FrontierPoint>& frontier, double maxWholeVisible);

/// Returns the advice under a budget that is not kept: what takes most of it, whether other layouts would help, the budget that allows it.
/// isChosen  the budget chose the layouts
std::string budgetAdvice(const std::vector<ReportRow>& rows, std::uint64_t usedBytes, bool isChosen);

}  // namespace lightcook::pipeline
