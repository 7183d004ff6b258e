// The section of a page about the budgets of platforms.
#pragma once

#include "pipeline/report/html.h"
#include "pipeline/report/page_parts.h"

namespace lightcook::pipeline {

/// platforms  the member of a report; null: an empty section
Html platformSection(const Json& platforms);

}  // namespace lightcook::pipeline
