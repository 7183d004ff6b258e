// Compares two JSON documents member by member.
#pragma once

#include <string>

#include "pipeline/document/json.h"

namespace lightcook::pipeline {

/// Calls report(path, found, expected) for each value that differs, with a path such as "constants/range". A member that is missing on one
/// side is null there.
template <class Report>
void eachDifference(const Json& found, const Json& expected, const Report& report, const std::string& path = {}) {
    if (!found.is_object() || !expected.is_object()) {
        if (found != expected) report(path, found, expected);
        return;
    }
    const auto placeOf = [&](const std::string& key) { return path.empty() ? key : path + "/" + key; };
    for (const auto& [key, value] : expected.items()) eachDifference(found.value(key, Json()), value, report, placeOf(key));
    for (const auto& [key, value] : found.items())
        if (!expected.contains(key)) report(placeOf(key), value, Json());
}

}  // namespace lightcook::pipeline
