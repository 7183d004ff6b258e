// report.html: one file that needs no other. The page is viewer/report; here are its data, and the table that readers without scripts see.
//
// Members of the data:
//   report      report.json of one scene, without the digests of files; or
//   collection  the JSON of a report of several scenes, with `links`, to the page of each, and `errors`, of platforms
//   uses        of each asset (of each scene), the limit that it is nearest to: `share`, null if it is not finite, and `words`
//   history     lines of a history
//   kinds       captions of the kinds of assets
//   formats     side [texels] and bytes of a block of each pixel format
//   pictures    data: URLs by file
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/graph/files.h"
#include "pipeline/report/collection.h"
#include "pipeline/report/history.h"
#include "pipeline/report/report.h"

namespace lightcook::pipeline {

/// Returns the page of a scene. Pictures are read from `folder`, and are in the page.
/// history  of this scene, for its trend
std::string renderReportHtml(const Report& report, const StagedFolder& folder, const std::vector<HistoryLine>& history = {});

/// Returns the page of several scenes. It opens fast with thousands of them: pictures are shown only where an error grew.
/// page     file that it will be written to, for links to the pages of the scenes; empty: no links
/// history  of all scenes; empty: no trend
std::string renderCollectionHtml(const CollectionReport& report, const std::filesystem::path& page,
                                 const std::vector<HistoryLine>& history);

}  // namespace lightcook::pipeline
