// Tables of the reference documents, from a JSON schema: one for the document, and one for each struct inside it.
#pragma once

#include <string>

#include "pipeline/document/json.h"

namespace lightcook::pipeline {

/// Returns Markdown tables of fields (field, type, meaning). Types that are structs link to their tables, which follow under headings of
/// their own.
std::string fieldTables(const Json& schema);

}  // namespace lightcook::pipeline
