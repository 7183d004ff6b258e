// The section of report.html that says what limits a scene, and what another choice would cost or save.
#pragma once

#include <string>
#include <vector>

#include "pipeline/graph/action.h"
#include "pipeline/report/html.h"

namespace lightcook::pipeline {

/// Returns the bytes of a light map's texture that lie outside charts; 0 for tables of learned layouts, other assets, and maps without that
/// figure.
std::uint64_t bytesOutsideCharts(const Json& asset, const Json& texture);

/// Returns sentences about memory and error. Each has figures that were measured in the cook (layouts that were tried) or that follow from
/// sizes alone. The most important one stands first.
std::vector<std::string> adviceOf(const Json& report);

/// Returns the section; empty without advice.
Html adviceSection(const Json& report);

}  // namespace lightcook::pipeline
