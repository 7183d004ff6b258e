// JSON schemas of the files that a cook leaves: docs/reference/cooked.schema.json and report.schema.json.
#pragma once

#include <string>

namespace lightcook::pipeline {

/// Returns the schema of cooked.json. Constants follow the kind of their asset.
std::string manifestSchema();
/// Returns the schema of report.json.
std::string reportSchema();

}  // namespace lightcook::pipeline
