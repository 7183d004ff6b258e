#include "pipeline/assets/verification.h"

#include "pipeline/assets/verdict.h"

namespace lightcook::pipeline {

double maxErrorOf(const ActionContext& context) {
    return context.action.parameters.at("max_error").get<double>();
}

ActionOutcome outcomeOf(std::vector<verify::StageError> stages, const ActionContext& context, const Stopwatch& watch,
                        const std::vector<verify::Violation>& violations) {
    if (!stages.empty()) stages.back().seconds = watch.seconds();
    ActionOutcome outcome;
    outcome.result["verdict"] = verdict(stages, maxErrorOf(context), violations);
    return outcome;
}

}  // namespace lightcook::pipeline
