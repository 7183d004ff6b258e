// A section of report.html: the error of the whole shading, and whose it is.
#pragma once

#include "pipeline/graph/action.h"
#include "pipeline/report/html.h"

namespace lightcook::pipeline {

/// whole  as wholeError gives it; nothing for what is no object. What is absent or of another type is a dash.
Html wholeSection(const Json& whole);

}  // namespace lightcook::pipeline
