// What an asset that did not pass is accused of: for the one line of the exit code, for JUnit and SARIF, and in report.json.
#pragma once

#include <string>
#include <vector>

#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// The asset's accusations, each
/// {"asset", "kind", "stage", "shading", "place", "texel", "mip", "face", "channel", "normal", "view", "m", "f0",
///  "reference", "found", "allowed", "message"},
/// as far as they are known: `found` is the light at the worst sample, `reference` what it should be, `allowed` how far it may be from
/// that. `message` is the line that tells of it. asset  a row of report.json, whole but for "failures"
Json failuresOf(const Json& asset);

/// A place as report.json has it ("sampled_at", "bound_at", "at"), in words: "texel (12, 31), green, normal (0, 0, 1)". Tolerates what is
/// absent or of another type.
std::string placeWords(const Json& at);

/// The errors of a report's failures, in their order: code Verification.
std::vector<formats::Error> errorsOf(const Json& failures);

}  // namespace lightcook::pipeline
