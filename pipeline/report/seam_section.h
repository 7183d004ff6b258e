// The part of an asset's section that shows its seams: steps of light at edges that charts share.
#pragma once

#include <string>

#include "pipeline/graph/action.h"
#include "pipeline/graph/files.h"
#include "pipeline/report/html.h"

namespace lightcook::pipeline {

/// Returns tables of the seams of an asset and pictures of the worst; empty for an asset without them.
/// folder  of the report, which has the pictures
Html seamSection(const StagedFolder& folder, const Json& asset);
/// Returns "between 'room' and 'room_fine'" for an edge between two light maps; empty for one inside a map.
std::string mapsOfSeam(const Json& seam);
/// Returns the same of the seams between the maps of a split light map; empty for an asset that is not the first of them.
Html splitSeamSection(const StagedFolder& folder, const Json& asset);

}  // namespace lightcook::pipeline
