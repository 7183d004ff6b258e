// A section of report.html: everything that the report holds about one asset.
#pragma once

#include "pipeline/graph/action.h"
#include "pipeline/graph/files.h"
#include "pipeline/report/html.h"

namespace lightcook::pipeline {

/// folder  of the cooked scene, where the asset's pictures lie
/// index   of the asset in the report, for assetAnchor
Html assetSection(const StagedFolder& folder, const Json& asset, std::size_t index);

}  // namespace lightcook::pipeline
