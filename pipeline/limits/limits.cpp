#include "pipeline/limits/limits.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "formats/vocabulary.h"
#include "pipeline/document/given_keys.h"

namespace lightcook::pipeline {
namespace {

constexpr std::array kLimits = {
    LimitInfo{Limit::Error, Limit::Error, "max_error", true, "limit on rel_rms of diffuse and of specular light", "rel_rms", "rel_rms {}",
              4},
    LimitInfo{Limit::Visible, Limit::Visible, "max_visible", false, "limit on the 99th percentile of visible errors", "visible p99",
              "a visible error of {} (p99)", 3},
    LimitInfo{Limit::VisibleBound, Limit::VisibleBound, "max_visible_bound", false, "limit on the proven bound of visible errors",
              "visible bound", "a visible error of up to {} (proven bound)", 3},
    LimitInfo{Limit::Seam, Limit::Seam, "max_seam", false, "limit on the largest step that cooking adds to an edge", "seam", "a seam of {}",
              3},
    LimitInfo{Limit::WholeError, Limit::WholeError, "max_whole_error", true,
              "limit on rel_rms of a light map and its dominant light together", "rel_rms with its dominant light", "rel_rms {}", 4},
    LimitInfo{Limit::WholeVisible, Limit::WholeVisible, "max_whole_visible", false,
              "limit on the 99th percentile of visible errors of a light map and its dominant light together",
              "visible p99 with its dominant light", "a visible error of {} (p99)", 3},
    LimitInfo{Limit::ConverterError, Limit::Error, "max_converter_error", true, "limit on rel_rms of an asset that is no light map",
              "rel_rms", "rel_rms {}", 4},
    LimitInfo{Limit::ConverterVisible, Limit::Visible, "max_converter_visible", false,
              "limit on the 99th percentile of visible errors of an asset that is no light map", "visible p99",
              "a visible error of {} (p99)", 3},
    LimitInfo{Limit::ConverterVisibleBound, Limit::VisibleBound, "max_converter_visible_bound", false,
              "limit on the proven bound of visible errors of an asset that is no light map", "visible bound",
              "a visible error of up to {} (proven bound)", 3},
};
static_assert(formats::isCompleteTable(kLimits, Limit::ConverterVisibleBound) && kLimits.size() == kLimitCount);

}  // namespace

std::span<const LimitInfo> allLimits() {
    return kLimits;
}

const LimitInfo& info(Limit limit) {
    return kLimits.at(static_cast<std::size_t>(limit));
}

const LimitInfo& converterLimit(Limit held) {
    return *std::ranges::find_if(kLimits, [&](const LimitInfo& each) { return each.isOfConverters() && each.held == held; });
}

std::string optionOf(const LimitInfo& limit) {
    return optionNamed(limit.name);
}

double Check::share() const {
    if (figure.value == 0) return 0;
    return std::isfinite(figure.value) && allowed > 0 ? figure.value / allowed : std::numeric_limits<double>::infinity();
}

std::vector<Check> judge(const std::vector<Figure>& figures, const Limits& limits) {
    std::vector<Check> checks;
    for (const Figure& each : figures)
        if (const auto& limit = limits[each.limit]) checks.push_back({each, *limit});
    return checks;
}

bool areKept(const std::vector<Check>& checks) {
    return std::ranges::all_of(checks, &Check::isKept);
}

std::optional<Check> mostUsed(const std::vector<Check>& checks) {
    const auto most = std::ranges::max_element(checks, {}, &Check::share);
    return most == checks.end() ? std::nullopt : std::optional(*most);
}

double mostUsedShare(const std::vector<Check>& checks) {
    const auto most = mostUsed(checks);
    return most ? most->share() : 0;
}

}  // namespace lightcook::pipeline
