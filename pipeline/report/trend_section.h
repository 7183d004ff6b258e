// The section of a page about the history of its scenes.
#pragma once

#include <vector>

#include "pipeline/report/history.h"
#include "pipeline/report/html.h"

namespace lightcook::pipeline {

/// Returns memory and errors over the steps of a history: a step ends before a scene is there again. Of several scenes the memory is the
/// sum of the latest line of each, and an error the largest of these. Empty with fewer than two steps. isOneScene  true if the page is of
/// one scene: the lines of others are left out before
Html trendSection(const std::vector<HistoryLine>& history, bool isOneScene);

}  // namespace lightcook::pipeline
