// The failures of an asset's verification: for error lines, JUnit, SARIF and report.json.
#pragma once

#include <string>
#include <vector>

#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// Returns the failures of an asset, a row of report.json without "failures". Each failure is
/// {"asset", "kind", "stage", "shading", "place", "texel", "mip", "face", "channel", "normal", "view", "m", "f0",
///  "reference", "found", "allowed", "message"},
/// as far as these are known. `found` is the light at the worst sample, `reference` that of the source, `allowed` the largest difference
/// that is within the limit. `message` is the error line.
Json failuresOf(const Json& asset);

/// Returns a place of report.json ("sampled_at", "bound_at", "at") as text: "texel (12, 31), green, normal (0, 0, 1)". Leaves out members
/// that are absent or of another type.
std::string placeWords(const Json& at);

/// Returns one error of code Verification for each failure, in the same order.
std::vector<formats::Error> errorsOf(const Json& failures);

}  // namespace lightcook::pipeline
