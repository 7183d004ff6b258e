// Errors as the report and the records carry them.
#pragma once

#include <optional>

#include "pipeline/graph/action.h"
#include "verify/block_errors.h"
#include "verify/figures.h"
#include "verify/violation.h"

namespace lightcook::pipeline {

/// What is known of {"mip", "face", "texel": [x, y], "channel", "normal", "view", "m", "f0", "reference", "found", "local"}.
Json toJson(const verify::ErrorPlace& place);
/// {"rel_rms", "p99", "max_sampled", "max_bound"}, and "sampled_at" and "bound_at" where the verifier tells of the places.
Json toJson(const verify::ErrorFigures& figures);
/// {"name", "seconds", "error": {"diffuse": {...}, "specular": {...}}}
Json toJson(const verify::StageError& stage);

/// A verdict: the last stage's rel_rms, of diffuse and of specular, within the limit, every figure a finite number, and no law broken.
/// {"stages": [...], "limit": {"metric", "value"}, "passed"}, and where there are some "violations": [{"place", "found", "expected", "at"}]
Json verdict(const std::vector<verify::StageError>& stages, double maxError, const std::vector<verify::Violation>& violations = {});

/// Tells of the worst block of an image if it errs by more than a map with this limit may. The violation's place in numbers is the
/// caller's.
std::optional<verify::BlockErrors::Block> checkBlocks(const verify::BlockErrors& blocks, const std::string& image, double maxError,
                                                      std::vector<verify::Violation>& violations, double leastMean = 0);
/// A stage that codes what the one before it left must not add to the error: `before` and `after` are names of stages.
void checkStage(const std::vector<verify::StageError>& stages, const std::string& before, const std::string& after,
                std::vector<verify::Violation>& violations);

}  // namespace lightcook::pipeline
