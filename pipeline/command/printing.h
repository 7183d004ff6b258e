// Results of commands as lines for people.
#pragma once

#include "pipeline/command/terminal.h"
#include "pipeline/json/json.h"
#include "pipeline/report/report.h"

namespace lightcook::pipeline {

/// Prints a report as a table: one row an asset, then the memory and the error of the whole scene.
void printReport(Terminal& terminal, const Report& report);
/// Prints the report of a job.
void printReport(Terminal& terminal, const Json& json);

/// Prints an object as indented lines "key: value".
void printJson(Terminal& terminal, const Json& json, const std::string& indent = "");

}  // namespace lightcook::pipeline
