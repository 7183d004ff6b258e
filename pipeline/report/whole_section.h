// A section of report.html: the error of the whole shading and the assets that it comes from.
#pragma once

#include "pipeline/graph/action.h"
#include "pipeline/report/html.h"

namespace lightcook::pipeline {

/// Returns the section of a result of wholeError; nothing if that is not an object. Members that are absent or of another type show as a
/// dash.
Html wholeSection(const Json& whole);

}  // namespace lightcook::pipeline
