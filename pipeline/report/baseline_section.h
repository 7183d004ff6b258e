// A section of report.html: what changed since an older report.
#pragma once

#include "pipeline/graph/action.h"
#include "pipeline/report/html.h"

namespace lightcook::pipeline {

/// Returns a row of the table of assets: bytes and errors before and now.
Html baselineRow(const Json& asset, const std::string& shownName);
Html baselineTable(const Html& rows);
/// Returns the pictures of an asset's errors before and now, if they grew and there are files of them.
Html grownErrorPictures(const Json& asset, const std::string& name);
/// Returns the section of "baseline" of a report; nothing if that is not an object. Members of another shape show as a dash.
Html baselineSection(const Json& baseline);

}  // namespace lightcook::pipeline
