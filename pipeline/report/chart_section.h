// The part of an asset's section that shows the charts of a light map: how much memory each takes, and how visible its errors are.
#pragma once

#include "pipeline/graph/action.h"
#include "pipeline/report/html.h"

namespace lightcook::pipeline {

/// Returns a treemap whose areas are bytes and whose colours are visible errors, and a table of the charts with the largest; empty for an
/// asset without charts.
Html chartSection(const Json& asset);

}  // namespace lightcook::pipeline
