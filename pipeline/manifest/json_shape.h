// Whether JSON that came from outside has the shape that the program reads it by. Both files are ours, but people, merges and disks change
// them.
#pragma once

#include <string>

#include "formats/error.h"
#include "pipeline/graph/action.h"

namespace lightcook::pipeline {

/// Parses; discarded (is_discarded()) if the text is no JSON, or nested deeper than any file of ours.
Json parseJson(const std::string& text);

/// Indented; bytes of a file name that are no UTF-8 become U+FFFD.
std::string textOf(const Json& json);

/// cooked.json: types, ranges, known kinds, files inside the folder. What a kind's "constants" hold is for its verifier to refuse.
/// subject   the file, for the error, which names the place in it: "assets/1/textures/0/file"
formats::Result<void> checkManifest(const Json& manifest, const std::string& subject);
/// report.json, as far as anything reads it.
formats::Result<void> checkReport(const Json& report, const std::string& subject);

}  // namespace lightcook::pipeline
