#include "pipeline/report/limit_use.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "pipeline/report/words.h"

namespace lightcook::pipeline {
namespace {

std::string wordsOf(const Check& check, const std::string& name) {
    const double value = check.figure.value;
    if (info(check.figure.limit).isFraction) return fmt::format("{} {} of {}", name, humanPercent(value), humanPercent(check.allowed));
    return fmt::format("{} {} of {:.3g}", name, std::isfinite(value) ? fmt::format("{:.2f}", value) : "not finite", check.allowed);
}

}  // namespace

std::optional<LimitUse> mostUsedLimit(const ReportRow& row) {
    std::optional<LimitUse> most;
    const auto take = [&](const std::vector<Check>& checks, const auto& nameOf) {
        for (const Check& check : checks)
            if (!most || check.share() > most->share) most = {check.share(), wordsOf(check, nameOf(check))};
    };
    const auto isMip = [&](const std::string& stage) {
        return std::ranges::find(row.mips, stage, &verify::StageError::name) != row.mips.end() ||
               std::ranges::find(row.mipBlends, stage, &verify::StageError::name) != row.mipBlends.end();
    };
    const auto nameOf = [&](const Check& check) {
        const std::string figure(info(check.figure.limit).figure);
        return isMip(check.figure.stage) ? check.figure.stage + " " + figure : figure;
    };
    take(row.checks(row.verdict.limits), nameOf);
    if (row.whole) take(row.whole->checks(), nameOf);
    return most;
}

}  // namespace lightcook::pipeline
