#include "pipeline/assets/verification.h"

#include <algorithm>

namespace lightcook::pipeline {

verify::Viewing VisibleParameters::viewing(double key, const glm::dmat3& bt2020FromWorking) const {
    return {display.value_or(lighting::DisplaySettings{}).of(key), bt2020FromWorking};
}

bool passes(const VerifyResult& result) {
    const auto isLevelFinite = [](const verify::StageError& level) { return isFinite(level.diffuse) && isFinite(level.specular); };
    return result.verdict.passed && result.verdict.violations.empty() && std::ranges::all_of(result.mips, isLevelFinite) &&
           std::ranges::all_of(result.mipBlends, isLevelFinite) && areKept(result.checks(result.verdict.limits));
}

VerifyResult judged(std::vector<verify::StageError> stages, Limits limits, const Stopwatch& watch,
                    std::vector<verify::Violation> violations) {
    if (!stages.empty()) stages.back().seconds = watch.seconds();
    if (!limits[Limit::Error]) limits[Limit::Error] = kNoErrorLimit;
    VerifyResult result;
    result.verdict = makeVerdict(std::move(stages), limits, std::move(violations));
    return result;
}

}  // namespace lightcook::pipeline
