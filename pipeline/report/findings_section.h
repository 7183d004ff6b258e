// A section of report.html: what lint found in the inputs.
#pragma once

#include "pipeline/graph/action.h"
#include "pipeline/report/html.h"

namespace lightcook::pipeline {

/// Returns the section of "findings" of a report; nothing if there are none.
Html findingsSection(const Json& report);

}  // namespace lightcook::pipeline
