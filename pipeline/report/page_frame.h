// Head, style and script of every page of the report.
#pragma once

#include <string>

#include "pipeline/report/html.h"

namespace lightcook::pipeline {

/// Returns the script of the pages. A page is whole without it; with it, tables are sorted and searched, and pictures are enlarged, blinked
/// and shown at other exposures.
std::string_view reportScript();

/// Returns a whole page.
std::string pageText(const std::string& title, const Html& main);

}  // namespace lightcook::pipeline
