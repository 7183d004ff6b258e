// cook --patch: a scene of which little was baked again. Decisions, and the plans of light maps whose bakes changed, are those of the last
// cook into the folder: then strips that did not change come from the cache, and their bytes stay.
#pragma once

#include <filesystem>
#include <string>

#include "formats/error.h"
#include "pipeline/cook/plan.h"
#include "pipeline/graph/digest.h"
#include "pipeline/graph/executor.h"
#include "pipeline/graph/part_cache.h"
#include "pipeline/scene/scene.h"

namespace lightcook::pipeline {

/// Returns the decisions of the last cook into a folder. They name the plans of light maps whose bakes have changed since
/// (Decisions::kept). Fails with the reason if they do not serve: nothing but bakes may have changed. options  of this cook parts    which
/// the plans are in
formats::Result<Decisions> keptDecisions(const Scene& scene, const PlanOptions& options, const std::filesystem::path& folder,
                                         const PartCache& parts, DigestMemo& digests);

/// Returns why kept decisions do not serve, now that the scene was cooked with them: an action failed, or a limit or the budget is missed.
/// Empty: they do.
std::string whyRefuted(const Scene& scene, const Plan& plan, const ExecutionResult& result);

}  // namespace lightcook::pipeline
