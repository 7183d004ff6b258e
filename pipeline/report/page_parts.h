// Access to report.json as JSON that tolerates absent members and members of another type.
#pragma once

#include <array>
#include <string>

#include "pipeline/document/json.h"
#include "pipeline/report/words.h"

namespace lightcook::pipeline {

inline constexpr std::array kShadings = {"diffuse", "specular"};

/// Returns the member, or null if the value is not an object or lacks the key.
const Json& member(const Json& object, const char* key);
/// Returns the member if it is an array, else an empty array.
const Json& list(const Json& object, const char* key);
/// Returns a string as it is; "" for other values.
std::string words(const Json& value);
/// Returns NaN unless the value is a finite number. JSON writes NaN and infinities as null; a report in memory looks like the file's.
double number(const Json& value);
/// Returns the last stage, or null for an asset without stages.
const Json& lastStage(const Json& asset);

}  // namespace lightcook::pipeline
