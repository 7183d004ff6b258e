// Checks that the files of a cooked folder, and the sources that it was cooked from, are unchanged.
#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "formats/error.h"
#include "pipeline/graph/files.h"
#include "pipeline/manifest/manifest.h"
#include "pipeline/report/report.h"

namespace lightcook::pipeline {

/// Returns an error for each file of a cooked folder that was changed: manifest and report by their own digests, all others by those that
/// these two have of them. A folder without a report is complete: an engine needs none.
std::vector<formats::Error> checkDigests(const std::filesystem::path& folder, const Manifest& manifest);

/// Returns an error for each file that a report names with another digest: the manifest, the page, the pictures.
std::vector<formats::Error> checkReportFiles(const StagedFolder& folder, const std::string& manifestText, const Report& report);

/// Returns the sources of an asset by role, and refuses one that changed: an error against another bake means nothing.
formats::Result<std::map<std::string, std::filesystem::path>> unchangedSources(const CookedAsset& asset,
                                                                               const std::filesystem::path& sceneDirectory);

}  // namespace lightcook::pipeline
