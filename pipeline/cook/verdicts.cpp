#include "pipeline/cook/verdicts.h"

#include <fmt/format.h>

#include "pipeline/report/failures.h"

namespace lightcook::pipeline {

using formats::Error;
using formats::ErrorCode;

void appendVerdicts(const Report& report, std::vector<Error>& errors) {
    for (const ReportRow& row : report.assets)
        for (formats::Error& error : errorsOf(row.failures)) errors.push_back(std::move(error));
    if (!report.budget.isKept())
        errors.push_back(
            {ErrorCode::OverBudget, "budget",
             fmt::format("found {} bytes of GPU memory, expected at most {}", report.budget.usedBytes, *report.budget.limitBytes)});
}

}  // namespace lightcook::pipeline
