// A section of report.html: what changed since an older report.
#pragma once

#include "pipeline/graph/action.h"
#include "pipeline/report/html.h"

namespace lightcook::pipeline {

/// Returns the section of "baseline" of a report; nothing if that is not an object. Members of another shape show as a dash.
Html baselineSection(const Json& baseline);

}  // namespace lightcook::pipeline
