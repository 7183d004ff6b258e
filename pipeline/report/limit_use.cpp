#include "pipeline/report/limit_use.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string_view>

#include "pipeline/report/words.h"

namespace lightcook::pipeline {
namespace {

/// Returns "whole visible" of max_whole_visible. Those of converters hold the same figures.
std::string briefName(const LimitInfo& limit) {
    std::string name(limit.name.substr(std::string_view("max_").size()));
    std::ranges::replace(name, '_', ' ');
    return name;
}

/// Returns false for the limit that only tells an error from light that is lost: nobody asked for it.
bool isAsked(const Check& check) {
    return check.figure.limit != Limit::Error || check.allowed < kNoErrorLimit;
}

std::string wordsOf(const Check& check, const std::string& name) {
    const double value = check.figure.value;
    if (info(check.figure.limit).isFraction) return fmt::format("{} {} of {:.3g} %", name, humanPercent(value), 100 * check.allowed);
    return fmt::format("{} {} of {:.3g}", name, std::isfinite(value) ? fmt::format("{:.2f}", value) : "not finite", check.allowed);
}

}  // namespace

std::optional<LimitUse> mostUsedLimit(const ReportRow& row) {
    std::optional<LimitUse> most;
    const auto isMip = [&](const std::string& stage) {
        return std::ranges::find(row.mips, stage, &verify::StageError::name) != row.mips.end() ||
               std::ranges::find(row.mipBlends, stage, &verify::StageError::name) != row.mipBlends.end();
    };
    const auto levelOf = [&](const Check& check) { return isMip(check.figure.stage) ? check.figure.stage + " " : std::string(); };
    const auto take = [&](const std::vector<Check>& checks) {
        for (const Check& check : checks)
            if (isAsked(check) && (!most || check.share() > most->share))
                most = {check.share(), wordsOf(check, levelOf(check) + std::string(info(check.figure.limit).figure)),
                        wordsOf(check, levelOf(check) + briefName(info(check.figure.limit)))};
    };
    take(row.checks(row.verdict.limits));
    if (row.whole) take(row.whole->checks());
    return most;
}

}  // namespace lightcook::pipeline
