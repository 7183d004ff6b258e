// Results of commands as lines for people.
#pragma once

#include "pipeline/command/terminal/terminal.h"
#include "pipeline/cook/cook.h"
#include "pipeline/document/json.h"
#include "pipeline/report/collection.h"
#include "pipeline/report/report.h"

namespace lightcook::pipeline {

/// Prints a report as a table: one row an asset, then the memory and the error of the whole scene.
void printReport(Terminal& terminal, const Report& report);
/// Prints the report of a job.
void printReport(Terminal& terminal, const Json& json);
/// Prints a warning for each finding that is neither an error, which ends the command, nor allowed by the scene file.
void printFindings(Terminal& terminal, const std::vector<Finding>& findings);
/// Prints a warning for each asset that lost light above the largest value of its texels.
void printClampedLight(Terminal& terminal, const Report& report);
/// Prints a warning for each asset whose source was repaired.
void printRepairs(Terminal& terminal, const Report& report);
/// Prints a warning of repaired texels, if there are any.
void warnOfRepairs(Terminal& terminal, const std::string& subject, std::int64_t texels);
/// Prints a warning for each asset that was left out, with the reason.
void printSkipped(Terminal& terminal, const Report& report);

/// Prints one line: verdict, assets, sizes, what came from the cache, time and place. With --log json it is an object on standard error.
void printSummary(Terminal& terminal, const Report& report, const Outcome& outcome);
/// Prints a comparison with a baseline as a table, one row an asset that changed, and the growth of the whole.
void printComparison(Terminal& terminal, const BaselineComparison& comparison);

/// Prints the report of several scenes: one row a scene, the largest first, then budgets, growth and totals.
void printCollection(Terminal& terminal, const CollectionReport& report);
/// Prints a line for each platform.
void printPlatforms(Terminal& terminal, const std::vector<PlatformUse>& platforms);

/// Prints an object as indented lines "key: value", fractions with six digits.
void printJson(Terminal& terminal, const Json& json, const std::string& indent = "");

}  // namespace lightcook::pipeline
