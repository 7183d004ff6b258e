// A picture of the cooked folder with its caption, as part of the page.
#pragma once

#include <string>

#include "pipeline/graph/files.h"
#include "pipeline/report/html.h"

namespace lightcook::pipeline {

/// Returns a picture that is embedded into the page.
/// file  relative to the folder
/// alt   words for readers who do not see the picture
/// isLight  true for tone-mapped light, which the page's script shows at other exposures
Html pictureFigure(const StagedFolder& folder, const std::string& file, const std::string& alt, const Html& caption, bool isLight = false);

}  // namespace lightcook::pipeline
