// JSON schemas of the files that a cook leaves: docs/reference/cooked.schema.json and report.schema.json.
#pragma once

#include <string>

#include "pipeline/document/json.h"

namespace lightcook::pipeline {

/// Returns the schema of cooked.json. Constants follow the kind of their asset.
Json manifestSchema();
/// Returns the schema of report.json.
Json reportSchema();
/// Returns the text of a schema: a line a member, lists of names in one.
std::string schemaText(const Json& schema);

}  // namespace lightcook::pipeline
