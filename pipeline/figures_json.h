// Errors as the report and the records carry them.
#pragma once

#include "pipeline/action.h"
#include "verify/figures.h"

namespace pipeline {

Json toJson(const verify::ErrorFigures& figures);
/// {"name", "seconds", "error": {"diffuse": {...}, "specular": {...}}}
Json toJson(const verify::StageError& stage);

/// A verdict: the last stage's rel_rms, of diffuse and of specular, within the limit, and every figure a finite number.
/// {"stages": [...], "limit": {"metric", "value"}, "passed"}
Json verdict(const std::vector<verify::StageError>& stages, double maxError);

}  // namespace pipeline
