#include "pipeline/assets/verification.h"

#include "pipeline/scene/settings.h"

namespace lightcook::pipeline {
namespace {

struct LimitParameter {
    std::optional<double> maxError;
};
template <class Fields, Is<LimitParameter> Self>
void describe(Fields& fields, Self& limit) {
    fields.optional("max_error", limit.maxError, "limit on rel_rms; absent: none");
}

}  // namespace

verify::Viewing VisibleParameters::viewing(double key, const glm::dmat3& bt2020FromWorking) const {
    return {display.value_or(lighting::DisplaySettings{}).of(key), bt2020FromWorking};
}

formats::Result<double> maxErrorOf(const ActionContext& context) {
    const auto limit = parametersOf<LimitParameter>(context);
    if (!limit) return tl::make_unexpected(limit.error());
    return limit->maxError.value_or(kNoErrorLimit);
}

VerifyResult judged(std::vector<verify::StageError> stages, double maxError, const Stopwatch& watch,
                    std::vector<verify::Violation> violations, const std::optional<double>& maxVisible,
                    const std::optional<double>& maxVisibleBound) {
    if (!stages.empty()) stages.back().seconds = watch.seconds();
    VerifyResult result;
    result.verdict = makeVerdict(std::move(stages), maxError, std::move(violations), maxVisible, maxVisibleBound);
    return result;
}

}  // namespace lightcook::pipeline
