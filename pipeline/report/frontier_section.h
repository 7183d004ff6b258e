// The section of report.html about what other budgets would buy.
#pragma once

#include "pipeline/graph/action.h"
#include "pipeline/report/html.h"

namespace lightcook::pipeline {

/// Returns the plot of bytes against visible error with the chosen allocation and the budget, the next steps down and up in words, and a
/// table of all allocations. Empty for a scene without a frontier.
/// budget  member of report.json
Html frontierSection(const Json& budget);

}  // namespace lightcook::pipeline
