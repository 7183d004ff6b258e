// A section of report.html: the error of the whole shading and the assets that it comes from.
#pragma once

#include "pipeline/graph/action.h"
#include "pipeline/report/html.h"

namespace lightcook::pipeline {

/// Returns the section of "whole" of a report; nothing if that is not an object. One of another shape shows without figures.
Html wholeSection(const Json& json);

}  // namespace lightcook::pipeline
