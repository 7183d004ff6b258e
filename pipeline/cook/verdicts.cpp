#include "pipeline/cook/verdicts.h"

#include <fmt/format.h>

#include "pipeline/report/failures.h"
#include "pipeline/report/report.h"

namespace lightcook::pipeline {

using formats::Error;
using formats::ErrorCode;

void appendVerdicts(const Json& report, std::vector<Error>& errors) {
    for (const Json& asset : report.at("assets"))
        if (!asset.at("passed").get<bool>())
            for (formats::Error& error : errorsOf(asset.value("failures", Json::array()))) errors.push_back(std::move(error));
    if (!isWithinBudget(report))
        errors.push_back(
            {ErrorCode::OverBudget, "budget",
             fmt::format("found {} bytes of GPU memory, expected at most {}", report.at("budget").at("used_bytes").get<std::uint64_t>(),
                         report.at("budget").at("limit_bytes").get<std::uint64_t>())});
}

}  // namespace lightcook::pipeline
